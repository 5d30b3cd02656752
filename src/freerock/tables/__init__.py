"""Tables of a campaign: tidy CSV, the numbers of the paper's tables; text as Markdown and LaTeX."""
