"""Figures of others that ours are put beside."""

# Completed tasks in 1800 s of the published M-ARK software (github.com/luigifeola/ARK_kilobots_dhtf_server at f9bb78b), run with the constants
# of the paper: 48 robots in 1.0 m and requirements 2/4 (Sh), 12 robots in 0.5 m and 1/2 (Ro). Each count is one run.
DHTF_RUNS = {
    ("Sh-Ro", "all easy"): [174, 165, 173, 158, 192, 155, 179, 159, 199, 136],
    ("Sh-Ro", "mixed"): [85, 89, 98, 94, 98, 77, 125, 90, 66],
    ("Sh-Ro", "all hard"): [49, 50, 43, 43, 62, 43, 66, 36, 71, 39],
    ("Ro-Ro", "all easy"): [142, 133, 164, 170, 151, 178, 120],
    ("Ro-Ro", "mixed"): [91, 64, 66, 95, 86, 90, 63],
    ("Ro-Ro", "all hard"): [33, 36, 35, 48, 36, 50, 26],
    ("Sh-Sh", "all easy"): [184, 159, 198, 184, 199, 156],
    ("Sh-Sh", "mixed"): [93, 87, 123, 119, 105, 98],
    ("Sh-Sh", "all hard"): [59, 52, 64, 42, 75, 39],
}
DHTF_PAIRS = ["Ro-Ro", "Sh-Ro", "Sh-Sh"]
DHTF_MIXES = ["all easy", "mixed", "all hard"]

# CRE in the paper (Feola, Reina, Talamali, Trianni, IEEE RA-L 2023, Fig. 7): of 100 symmetric runs.
CRE_SYMMETRIC_SOUTH, CRE_SYMMETRIC_RUNS = 63, 100
