"""Chapter 5 of T. Stone's thesis, figure by figure: Stone et al. 2017, Current Biology 27:3069."""

PAPER = "Stone et al. 2017"
