"""Publisher, matcher, and all others on three hosts: the map is the one of a single host."""

from faults import check_same_results, hosts, run, run_on_hosts, run_stack


def test(case):
    for name, log, flags in case.logs():
        alone = case.folder("one_host")
        alone_s = run_stack(log, alone, flags)
        with hosts(3) as members:
            for times in range(1 if case.quick else 3):
                out = case.folder("three_hosts")
                took_s = run_on_hosts(members, log, out, flags)
                check_same_results(out, alone)
                case.say(f"{name}: same map; {alone_s:.1f} s on one host, {took_s:.1f} s on three")


run(test)
