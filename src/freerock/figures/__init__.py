"""Figures: a module each, found by the figure's name, with its function `draw`; and what figures share.

A new figure is a module here and an entry in figures.toml. `READS` names the variables that it reads of
datasets. `draw` takes the tables and datasets that it draws, `origin` and `labels`. `origin` of the records,
"simulated" or "measured", stands in the figure. `labels` are printed names of blocks and foundations. It
returns the figure and the numbers drawn; `style.save` writes both. Its function `caption` says more of these
numbers, such as the runs drawn. `figures.toml` has title, caption and what is read for each; the workflow
reads it without importing a module (`listed`).
"""
