#!/bin/sh
# Processor time and bytes of a study in one process, in shards, by Slurm and over ssh.
#   ./firn bench study_shards [--study STUDY] [--shards 40] [--chunk 60] [--ways shards,slurm,ssh] [OPTION…]
exec python3 -B "$(dirname "$0")/study_shards.py" "$@"
