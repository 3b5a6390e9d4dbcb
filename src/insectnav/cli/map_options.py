"""The options of the commands of maps: tables, from which the commands are made."""

from insectnav.cli.option_tables import COUNT, FLAG, NUMBER, TEXT, Argument, Option

FRAMES: Argument = (
    "frames", list[str],
    "Folder of pictures, pattern such as 'walk/left_*.png', film, recording of a robot (ROS 1 or 2), or features of "
    "your own as .npy or .zarr (frame, feature).", "FRAMES...",
)  # fmt: skip
MAP: Argument = ("map_folder", str, "Folder of the map.", "MAP")
DESCRIBE: tuple[Option, ...] = (
    ("--descriptor", TEXT, "patch-normalised, patch-normalised-v1, retinotopic; with a camera that sees all round also "
     "turned-views, rotations, binary-sky, spherical-harmonics, zernike, sky-contour, frequency-strip, "
     "zernike-orthonormal, zernike-disk; of features of your own any word",
     "patch-normalised, or as in the map", "NAME"),
    ("--camera", TEXT, "ahead; panorama or panorama:LOW,HIGH [deg]; fisheye or fisheye:FIELD [deg], looking up; "
     "mirror:RADIUS of the horizon [px]", "ahead, or as in the map", None),
    ("--sky", TEXT, "none: grey; mask: pictures are masks of the sky; or a method of `insectnav segment`",
     "grey for patch-normalised and -v1, retinotopic, turned-views and frequency-strip, else skylight for colour and "
     "watershed for grey",
     "METHOD"),
    ("--metric", TEXT, "Of features of your own: cosine, euclidean, absolute or hamming", "cosine", None),
)  # fmt: skip
WHERE: tuple[Option, ...] = (
    ("--positions", TEXT, "Where the frames were taken: CSV, GPX, NMEA, or the recording of a robot", "", "FILE"),
    ("--position-columns", TEXT, "Of positions without a header, as time_ms,x_cm,y_cm", "", "NAMES"),
    ("--position-topic", TEXT, "Of positions in the recording of a robot", "the only one", None),
    ("--times", TEXT, "When they were taken: CSV, their names, EXIF, or frames a second", "", "FILE|names|exif|RATE"),
    ("--time-offset", NUMBER, "Added to the times of the frames [s]", "0", None),
    ("--utc-offset", NUMBER, "Of clocks that name no time zone [h]", "0", None),
    ("--first-day", TEXT, "Of the log of a receiver that tells times of day alone, as 2014-05-06 (UTC)", "", "DATE"),
    ("--max-gap", NUMBER, "Between two positions that is bridged [s]", "3", None),
    ("--clock", TEXT, "Of the recording of a robot: stamp, when a message was made, or bag, when it arrived", "stamp",
     None),
    ("--topic", TEXT, "Of the pictures in the recording of a robot", "the only one", None),
)  # fmt: skip
THIN: tuple[Option, ...] = (
    ("--step", COUNT, "Take every so many frames", "1", None),
    ("--every-m", NUMBER, "Take frames so far from the one taken before [m]", "", None),
    ("--every-s", NUMBER, "Take frames so long after the one taken before [s]", "", None),
)
MATCH: tuple[Option, ...] = (
    ("--sequence-length", COUNT, "Steps from the first to the last frame; 1: frames one by one", "10", None),
    ("--slowest", NUMBER, "Places per query", "0.8", None),
    ("--fastest", NUMBER, "Places per query", "1.2", None),
    ("--contrast-window", COUNT, "Neighbouring places that a difference is measured against; more in dense maps", "10",
     None),
    ("--unique-window", COUNT, "Neighbouring places that count as the same one in the score; more in dense maps", "10",
     None),
    ("--threshold", NUMBER, "Keep matches of this score or less: 0 unique, 1 as good as another place", "all", None),
    ("--search", TEXT, "exact: compare with all places; index: with those that an index proposes; auto: the index of "
     "frozen maps of more than 60 000 places", "auto", None),
)  # fmt: skip
TRUTH: tuple[Option, ...] = (
    ("--truth", TEXT, "Table of query and reference: numbers from 0, or names of frames", "", "FILE.csv"),
    ("--key-frames", TEXT, "The same of some frames, between which the truth is a straight line", "", "FILE.csv"),
    ("--same-index", FLAG, "Query k was taken at place k", "", None),
    ("--tolerance-frames", NUMBER, "With a truth in frames: error of a right match", "2", None),
    ("--tolerance-m", NUMBER, "With --positions: error of a right match [m]", "", None),
)
HOW: tuple[Option, ...] = (
    ("--no-pictures", FLAG, "Keep and show no small pictures of the frames", "", None),
    ("--workers", COUNT, "Number of threads", "one for each core", None),
    ("--json", FLAG, "Print one JSON object and nothing else", "", None),
)
BUILD: tuple[Option, ...] = (
    ("--add", FLAG, "Add another route to a map, or go on with a build that was interrupted", "", None),
    ("--freeze", FLAG, "Close the map for good, and index it", "", None),
)
LEAVE: tuple[Option, ...] = (
    ("--out", TEXT, "Table of matches", "", "FILE.csv"),
    ("--page", TEXT, "Page with figures, pairs of frames and numbers, all in one file", "", "FILE.html"),
    ("--out-dir", TEXT, "Folder for table, page, figures and numbers", "out/locate-NAME if no file is named", None),
    ("--title", TEXT, "Of the page", "names of frames and map", None),
)
OF_BUILD = (*DESCRIBE, *WHERE, *THIN, *BUILD, *HOW)
OF_LOCATE = (*LEAVE, *MATCH, *TRUTH, *DESCRIBE, *WHERE, *THIN, *HOW)
OF_EVALUATE = (*TRUTH, *MATCH, *DESCRIBE, *WHERE, *THIN, *HOW[1:])
