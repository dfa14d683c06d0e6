# For scripts that build.

# own_folder BUILD: removes what was built where this clone was before, or in the clone that it is a copy of. Such a folder names sources elsewhere.
own_folder() {
  local made_at
  made_at=$(sed -n 's/^CMAKE_HOME_DIRECTORY:INTERNAL=//p' "$1/CMakeCache.txt" 2>/dev/null) || return 0
  if [ -n "$made_at" ] && ! [ "$made_at" -ef . ]; then
    echo "build: $1 was made in $made_at, and this is $PWD; builds anew"
    rm -rf "$1"
  fi
}
