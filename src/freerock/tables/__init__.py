"""Tables of a campaign: tidy CSV, the numbers of the paper's tables, and these as printed text and LaTeX."""
