"""Where on a known route a view was taken: frames compared, sequences of them matched, headings found."""

from insectnav.matching.chow_liu import ChowLiuTree, chow_liu_tree
from insectnav.matching.compass import (
    TurnMatrix,
    VisualCompass,
    disk_turn_matrix,
    nearest_view,
    turn_matrix,
    turns_of_matches,
)
from insectnav.matching.constellations import (
    ConstellationIndex,
    ConstellationParams,
    constellation_index,
    locate_by_constellations,
)
from insectnav.matching.difference import METRICS, References, difference_matrix, prepare_references
from insectnav.matching.fabmap import FabMapMatches, FabMapParams, fabmap
from insectnav.matching.fabmap_store import FabMapModel, open_fabmap, save_fabmap
from insectnav.matching.place_about import MapAbout
from insectnav.matching.places import PlaceMap, merge_maps
from insectnav.matching.rotation import RotationIndex, RotationParams, build_rotation_index
from insectnav.matching.rotation_matches import RotationMatches, rotation_angles, rotation_between
from insectnav.matching.seqslam import OPENSEQSLAM_V1, Matches, SeqSlamParams, enhance_contrast, seqslam
from insectnav.matching.stream import Stream, StreamMatch, begin_stream, locate_next
from insectnav.matching.visual_words import Vocabulary, build_vocabulary, vocabulary_of_features

__all__ = [
    "METRICS",
    "OPENSEQSLAM_V1",
    "ChowLiuTree",
    "ConstellationIndex",
    "ConstellationParams",
    "FabMapMatches",
    "FabMapModel",
    "FabMapParams",
    "MapAbout",
    "Matches",
    "PlaceMap",
    "References",
    "RotationIndex",
    "RotationMatches",
    "RotationParams",
    "SeqSlamParams",
    "Stream",
    "StreamMatch",
    "TurnMatrix",
    "VisualCompass",
    "Vocabulary",
    "begin_stream",
    "build_rotation_index",
    "build_vocabulary",
    "chow_liu_tree",
    "constellation_index",
    "difference_matrix",
    "disk_turn_matrix",
    "enhance_contrast",
    "fabmap",
    "locate_by_constellations",
    "locate_next",
    "merge_maps",
    "nearest_view",
    "open_fabmap",
    "prepare_references",
    "rotation_angles",
    "rotation_between",
    "save_fabmap",
    "seqslam",
    "turn_matrix",
    "turns_of_matches",
    "vocabulary_of_features",
]
