"""Keys: exact, the same for every batch size, with the geometry of SimHash."""

import numpy as np
import pytest

from curionav_cli.agents.image_hash import ChangeKeys, ImageVector, SignKeys, StateKeys


@pytest.fixture
def rng():
    return np.random.default_rng(3)


def pictures(rng, *shape):
    return rng.integers(0, 256, (*shape, 64, 64, 3), np.uint8)


def test_sums_are_exact_in_any_order(rng):
    keys = SignKeys(49152, 128, rng)
    vectors = rng.integers(0, 256, (70, 49152), np.uint8)
    vectors[0] = 255
    exact = vectors.astype(np.int64) @ keys.signs.astype(np.int64)
    assert (keys.sums(vectors) == exact).all() and np.abs(exact).max() < 2**24
    order = rng.permutation(49152)
    shuffled = SignKeys(49152, 128, np.random.default_rng(0))
    shuffled.signs = keys.signs[order]
    assert (shuffled.sums(vectors[:, order]) == exact).all()


def test_a_key_does_not_depend_on_its_batch(rng):
    images = pictures(rng, 130)
    keys = StateKeys("raw", 128, rng)
    together = keys(images)
    assert together == [keys(image[None])[0] for image in images]
    assert together == [key for at in range(0, 130, 8) for key in keys(images[at:at + 8])]
    assert keys(images) == together and len(set(together)) == 130


def test_no_two_of_a_thousand_pictures_share_a_key(rng):
    noise = rng.integers(0, 256, (1000, 12288), np.uint8)
    assert len(set(SignKeys(12288, 128, rng)(noise))) == 1000


@pytest.mark.parametrize("degrees", [10, 45, 90, 135])
def test_a_digit_differs_as_often_as_the_angle_says(rng, degrees):
    numbers, bits, angle = 3000, 4000, np.radians(degrees)
    one, other = (part - part.mean() for part in rng.normal(size=(2, numbers)))
    other -= one * (one @ other) / (one @ one)
    other *= np.linalg.norm(one) / np.linalg.norm(other)
    pair = np.round(1000 * np.stack([one, np.cos(angle) * one + np.sin(angle) * other]))
    first, second = SignKeys(numbers, bits, rng).sums(pair) > 0
    expected = angle / np.pi
    assert abs((first != second).mean() - expected) < 4 * (expected * (1 - expected) / bits) ** 0.5


def test_zero_is_a_digit_of_its_own(rng):
    keys = SignKeys(4, 16, rng)
    nothing, something = keys(np.array([[0, 0, 0, 0], [1, 0, 0, 0]]))
    assert nothing == bytes(2) + b"\xff\xff" and something.endswith(bytes(2))
    balanced = keys(np.array([[1, 1, 0, 0]]))[0]
    assert balanced not in (nothing, something)


@pytest.mark.parametrize("wrapped, expected", [(True, [254, 2]), (False, [-2, 2])])
def test_a_difference_wraps_or_keeps_its_sign(wrapped, expected):
    before, after = np.zeros((2, 1, 1, 64, 64, 3), np.uint8)
    before[0, 0, 0, :2, 0], after[0, 0, 0, :2, 0] = (5, 3), (3, 5)
    change = ImageVector("raw", 1).change(before, after, wrapped)
    assert change[0, [0, 3]].tolist() == expected and np.count_nonzero(change) == 2


@pytest.mark.parametrize("key, side", [("grey_8", 8), ("grey_16", 16)])
def test_grey_cells_are_sums_of_their_pixels(rng, key, side):
    images = pictures(rng, 2, 4)
    vector, block = ImageVector(key, 4), 64 // side
    sums = [images[1, view, block * row:block * (row + 1), block * column:block * (column + 1)].sum()
            for view in range(4) for row in range(side) for column in range(side)]
    middle = block * block * 3 * 127.5
    assert (vector.state(images)[1] == np.array(sums) - middle).all()
    assert vector.numbers == len(sums) and abs(vector.state(images)).mean() < middle / 4
    change = vector.change(images[:1], images[1:], False)
    assert (change == vector.state(images[1:]) - vector.state(images[:1])).all()


def test_keys_of_changes_are_those_of_the_differences(rng):
    shown = pictures(rng, 3, 4)
    which, reached = np.array([0, 0, 1, 2, 2]), np.array([1, 2, 3, 0])
    keys = ChangeKeys("raw", 64, 4, True, rng)
    changes = keys((shown, which), reached)
    for n, key in enumerate(changes):
        difference = shown[which[reached[n]]] - shown[which[n]]
        assert key == keys.keys(difference.reshape(1, -1))[0]
    assert changes[0] == keys.nothing and len(set(changes)) == 4
