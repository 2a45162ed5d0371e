"""Equal images: found wherever they are, and told from images that differ in one number."""

import numpy as np

from curionav_cli.agents.distinct import distinct
from curionav_cli.agents.image_hash import StateKeys


def images():
    """Five of which the first, third and fifth are equal; the fourth differs from the second in one number."""
    made = np.random.default_rng(0).integers(0, 255, (5, 64, 64, 3), np.uint8)
    made[2] = made[4] = made[0]
    made[3] = made[1]
    made[3, 10, 20, 1] += 1
    return made


def test_each_image_belongs_to_the_first_of_its_kind():
    made = images()
    first, which = distinct(made)
    assert first.tolist() == [0, 1, 3] and which.tolist() == [0, 1, 0, 2, 0]
    assert (made[first][which] == made).all()
    assert [len(part) for part in distinct(made[:0])] == [0, 0]


def test_keys_of_equal_images_are_those_of_each_alone():
    keys = StateKeys("raw", 128, np.random.default_rng(1))
    made = images()
    assert keys(made) == [keys(made[n:n + 1])[0] for n in range(len(made))]
