"""A campaign of one record in two texts."""

YAML = """\
title: Blocks
origin: measured
blocks:
  tall:
    height_m: 0.28
    width_m: 0.07
    mass_kg: 5.84
foundations:
  marble: {}
lasers:
  near: {beam: horizontal, position_m: 0.1, range_m: 0.05}
"""
HEADER = "test,file,channel,block,foundation,laser,exclude,override,reason,note\n"
CSV = HEADER + "a,a.tdms,,tall,marble,near,,,,\n"
