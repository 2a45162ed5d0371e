"""The network: its published size, its first weights, and unrolls that equal acting step by step."""

import pytest
import torch

from curionav_cli.agents.cbet.acting import NumpyActor, TorchActor, actor
from curionav_cli.agents.cbet.learner import build_networks
from curionav_cli.agents.cbet.network import Memory, PolicyNetwork

T, B = 7, 3


@pytest.fixture
def network(tiny):
    made = build_networks(tiny(), torch.Generator().manual_seed(0), torch.device("cpu")).policy
    with torch.no_grad():
        for weight in made.parameters():
            weight.mul_(2)
    return made


@pytest.fixture
def image():
    return torch.randint(0, 256, (T + 1, B, 64, 64, 3), dtype=torch.uint8, generator=torch.Generator().manual_seed(1))


def test_sizes(hyper):
    with torch.device("meta"):
        sizes = [sum(p.numel() for p in PolicyNetwork(hyper(scale)).parameters()) for scale in ("paper", "cpu")]
        assert PolicyNetwork(hyper("paper")).eyes.features == 128
    assert sizes[0] == 896 + 4 * 9_248 + 132_096 + 1_049_600 + 2 * 8_396_800 + 3_075 + 1_025 == 18_017_284
    assert 140_000 < sizes[1] < 160_000


def test_first_weights(tiny):
    one, same, other = (build_networks(tiny(), torch.Generator().manual_seed(seed), torch.device("cpu")).policy
                        for seed in (0, 0, 1))
    assert all((a == b).all() for a, b in zip(one.parameters(), same.parameters(), strict=True))
    assert (one.value.weight != other.value.weight).any()
    rows = one.dense[0].weight
    torch.testing.assert_close(rows @ rows.T, 2 * torch.eye(len(rows)))
    torch.testing.assert_close(one.policy.weight @ one.policy.weight.T, torch.eye(3))
    assert not one.policy.bias.any() and not one.eyes.layers[0].bias.any()


@pytest.mark.parametrize("respawned", [[False] * B, [True, False, True]])
def test_an_unroll_is_acting_step_by_step(network, image, respawned):
    memory = Memory(*(0.5 * torch.randn(2, B, 6, generator=torch.Generator().manual_seed(2)) for _ in range(2)))
    frame = torch.arange((T + 1) * B).view(T + 1, B)
    logits, value = network.unroll(image.flatten(0, 1), frame, memory, torch.tensor(respawned))
    for step in range(T):
        output, memory = network._cells(network._encode(image[step]), memory)
        torch.testing.assert_close(logits[step], network.policy(output))
        torch.testing.assert_close(value[step], network.value(output).squeeze(-1))
    memory = Memory(*(part * ~torch.tensor(respawned)[None, :, None] for part in memory))
    output, _ = network._cells(network._encode(image[T]), memory)
    torch.testing.assert_close(value[T], network.value(output).squeeze(-1))


def test_colours_and_memory_change_the_policy(network, image):
    zero = network.initial(B)
    logits, memory = network.step(image[0], zero)
    assert (logits != network.step(image[0].flip(-1), zero)[0]).any()
    assert (logits != network.step(image[0], memory)[0]).any()


def test_acting_in_numpy_is_acting_in_torch(network, image):
    numpy, torchs = NumpyActor(network), TorchActor(network)
    assert type(actor(network)) is NumpyActor and not numpy.memory()[0].any()
    for frame in image[:, 0].numpy():
        torch.testing.assert_close(*(torch.from_numpy(each.step(frame)) for each in (numpy, torchs)))
        for ours, theirs in zip(numpy.memory(), torchs.memory(), strict=True):
            torch.testing.assert_close(torch.from_numpy(ours), torch.from_numpy(theirs))
    again = image[0, 0].numpy()
    torch.testing.assert_close(*(torch.from_numpy(each.step(again)) for each in (numpy, torchs)))
    assert len(numpy.inputs) == len(image)
    kept = numpy.memory()
    numpy.step(image[0, 1].numpy())
    assert (kept[0] != numpy.memory()[0]).any()


def test_acting_keeps_the_weights_of_its_beginning(network, image):
    begun, frame = NumpyActor(network), image[0, 0].numpy()
    with torch.no_grad():
        for weight in network.parameters():
            weight.mul_(1.5)
    assert (begun.step(frame) != NumpyActor(network).step(frame)).any()
