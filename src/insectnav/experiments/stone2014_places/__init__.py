"""Second half of Stone et al. 2014, Robotics: Science and Systems X: a city walk recognised on another day."""

PAPER = "Stone et al. 2014"
