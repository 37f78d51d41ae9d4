#!/bin/sh
# Starts the compiler through ccache: ccache.sh TREE COMPILER ARGUMENT...
export CCACHE_SLOPPINESS=pch_defines,time_macros # Precompiled headers prevent hits otherwise.
export CCACHE_BASEDIR="$1"                       # Paths relative to the tree, so that clones share results.
shift
# While a precompiled header is made, the compiler would read the one that is there: no result would be found again.
case "$*" in
  *" -x c++-header "*)
    output=
    for argument in "$@"; do
      [ "$output" != "-o" ] || { rm -f "$argument"; break; }
      output=$argument
    done
    ;;
esac
exec ccache "$@"
