"""What could corrupt a run, predicted: `deformed` stiffening as the plate deforms, `flutter` growth by friction,
`rounding` what it does to the reaction of a stiff plate in millions of steps.
"""

from fem.lazy import lazily

__all__, __getattr__ = lazily(
    __name__,
    {
        "deformed": "deformed_frequency",
        "flutter": "Flutter predict_flutter",
        "rounding": "RoundingNoise rounding_noise",
    },
)
