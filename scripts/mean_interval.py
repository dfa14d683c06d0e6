"""The 95 % interval of a mean."""
import statistics

T95 = [12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262, 2.228, 2.201, 2.179, 2.160, 2.145, 2.131, 2.120, 2.110, 2.101,
       2.093, 2.086, 2.080, 2.074, 2.069, 2.064, 2.060, 2.056, 2.052, 2.048, 2.045]


def interval(sample):
    """Half of the 95 % interval of a mean; by the normal distribution from 31 values on, else by Student's t."""
    n = len(sample)
    if n < 2:
        return 0.0
    return (T95[n - 2] if n < 31 else 1.96) * statistics.stdev(sample) / n ** 0.5
