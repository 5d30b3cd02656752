"""What the snippets share: instants, and equal strips of the base."""


def steps(scene):
    """Number of intervals at whose ends θ is requested."""
    return round(scene["until_s"] / scene["every_s"])


def substeps(scene, step_s):
    """Steps of an interval."""
    return max(1, round(scene["every_s"] / step_s))


def places(scene, n):
    """Middles of n equal strips of the base [m], and their width."""
    b = scene["b"]
    return [b * ((2 * i + 1) / n - 1) for i in range(n)], 2 * b / n
