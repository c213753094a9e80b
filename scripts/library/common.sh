# Sourced by the scripts of the folder above.

# Prints the comment at the top of the script if -h or --help is among the arguments, and ends the
# script.
answer_help() {
  local argument
  for argument in "$@"; do
    [[ $argument == -h || $argument == --help ]] || continue
    sed -n '2,/^[^#]/s/^# \{0,1\}//p' "$0"
    exit 0
  done
}
