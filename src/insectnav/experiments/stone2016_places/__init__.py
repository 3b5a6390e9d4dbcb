"""Second paper of chapter 4 of T. Stone's thesis: Stone, Differt, Milford & Webb 2016, ICRA.

Skyline-based localisation for aggressively manoeuvring robots using UV sensors and spherical harmonics. Views are
rendered: the recordings of the paper are not public.
"""

PAPER = "Stone et al. 2016"
