# Completes the programs' flags in bash, from their --help.
_crsm_slam() {
  local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD-1]} help words=
  help=$("$1" --help 2>/dev/null) || return
  case $word in
    -*) words=$(grep -oE '^  (-h, )?--[a-z0-9-]+(, --[a-z0-9-]+)*' <<<"$help" | grep -oE -- '--[a-z0-9-]+') ;;
    *)
      case $before in
        --preset | --profile) words=$(sed -nE "s/^  $before NAME *[a-z]+: //p" <<<"$help" | tr -d ,) ;;
        --*) words=$(sed -nE "s/^  $before ([a-z_]+(\|[a-z_]+)*)( .*)?$/\1/p" <<<"$help" | tr '|' ' ') ;;
        *) words=$(sed -n '/^Subcommands:/,$s/^  \([a-z_]*\) .*/\1/p' <<<"$help") ;;
      esac
      ;;
  esac
  mapfile -t COMPREPLY < <(compgen -W "$words" -- "$word")
}
complete -o default -F _crsm_slam laser_publisher ray_selector rrhc_matcher map_updater loop_closer map_exporter \
  map_viewer mbot_publisher fleet_mapper fleet_relay slam_offline slam_eval run_stack
