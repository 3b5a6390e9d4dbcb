"""First half of chapter 3 of T. Stone's thesis: Stone et al. 2014, Robotics: Science and Systems X."""

PAPER = "Stone et al. 2014"
