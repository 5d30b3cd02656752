"""What is drawn in a figure lies apart, and within it."""


def assert_nothing_overlaps(figure, name):
    figure.draw_without_rendering()
    boxes = [ax.get_tightbbox() for ax in figure.axes if ax.axison]
    boxes += [artist.get_window_extent() for artist in (*figure.texts, *figure.legends)]
    for i, box in enumerate(boxes):
        assert not any(box.overlaps(other) for other in boxes[i + 1 :]), name
        assert box.x0 > -1 and box.x1 < figure.bbox.x1 + 1, name
