"""Tables: tidy frames, the paper's tables, numbers as text, LaTeX."""
