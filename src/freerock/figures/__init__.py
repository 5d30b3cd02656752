"""Figures: a module each, found by the figure's name, with its function `draw`; and what figures share.

A new figure is a module here and an entry in figures.toml. Of datasets it reads the variables in `READS`.
It takes the tables and datasets it draws, the `origin` of their records ("simulated" or "measured"; the
figure states it) and `labels`, printed names of blocks and foundations. It returns the figure
and the numbers drawn; `style.save` writes both. What a figure of a campaign says of these numbers in its
caption, such as the runs drawn, comes from its function `caption`. `figures.toml` has title, caption and
what is read for each; the workflow reads it without importing a module (`listed`).
"""
