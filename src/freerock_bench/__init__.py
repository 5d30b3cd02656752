"""Studies of the methods: what they cost, how far they are from the truth, and where they fail.

A study is a module, and in it one function, `run(size)`, which gives the study's table. Its size is "full" or
"small": a few cases of everything, in seconds. What several studies need stands beside them.
"""
