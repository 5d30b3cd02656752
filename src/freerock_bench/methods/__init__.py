"""Methods to compare freerock with, each in its field's usual form; `by_name` lists them."""
