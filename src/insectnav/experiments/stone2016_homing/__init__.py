"""Section 4.3 of T. Stone's thesis, figure by figure: homing by views in a simulated ant world.

Figures and claims are those of the thesis, first shown as a poster at the ICN 2016. The paper that followed is Stone,
Mangan, Wystrach & Webb 2018, Interface Focus 8:20180010, doi 10.1098/rsfs.2018.0010; its figures are not what is run
again here, so the folder has the name of the earlier work.
"""

PAPER = "Stone 2016 (thesis section 4.3)"
