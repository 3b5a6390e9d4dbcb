"""Pictures of a world: a view, a panorama or a traverse with masks, poses and light, as a labelled set of data."""
