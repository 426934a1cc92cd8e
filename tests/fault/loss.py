"""A network that loses packets: the map is the one of a network that loses none, and takes longer."""

from faults import check, check_same_results, hosts, num_lost, read_log, run, run_on_hosts, run_stack, summary
from faults import write_log


def test(case):
    num_most = 150 if case.quick else 1500
    courses = [(name, read_log(log)[:num_most], flags) for name, log, flags in case.logs()]
    courses += [(name, read_log(log), flags) for name, log, flags in case.logs_that_break()]
    for name, scans, flags in courses:
        num_scans = len(scans)
        log = case.out / "beginning.lcm"
        write_log(log, scans)
        undisturbed = case.folder("undisturbed")
        run_stack(log, undisturbed, flags)

        def lose(share, where, map_log):
            out = case.folder("lossy")
            with hosts(1 if where == "one host" else 3, share) as members:
                took_s = map_log(members, out)
                lost = num_lost(members) if share else 0
            check_same_results(out, undisturbed)
            check(lost > 0 or not share, "no packet was lost")
            case.say(f"{name}, {where}, {100 * share:.0f} % lost: same map, {1000 * took_s / num_scans:.1f} ms a scan; "
                     f"{lost} packets lost, {summary(out)['counts'].get('laser_publisher.resent', 0)} scans sent again")

        for share in (0.0, 0.01, 0.05):
            lose(share, "one host", lambda members, out: run_stack(log, out, flags, members[0]))
        for part_bytes in ([], ["--part-bytes", "1400"]):
            for share in (0.0, 0.01, 0.05):
                lose(share, " ".join(["three hosts", *part_bytes]),
                     lambda members, out: run_on_hosts(members, log, out, flags, part_bytes))


run(test)
