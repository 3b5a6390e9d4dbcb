"""Section 4.3 of T. Stone's thesis, figure by figure: homing by views in a simulated ant world (a poster at the ICN 2016).

The figures and claims are those of the thesis. The work came out as Stone, Mangan, Wystrach & Webb 2018, Interface Focus
8:20180010, doi 10.1098/rsfs.2018.0010, whose figures are others; so the folder has the name of what it runs again.
"""

PAPER = "Stone 2016 (thesis section 4.3)"
