"""What each curiosity learns from a batch, and its intrinsic reward in imagination, against plain computations."""

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import torch
from torch.distributions import Independent, OneHotCategorical, kl_divergence

from curionav_cli.agents.lbs_dreamer.behaviour import Imagined
from curionav_cli.agents.lbs_dreamer.curiosity import choose
from curionav_cli.agents.lbs_dreamer.curiosity.choose import kind
from curionav_cli.agents.lbs_dreamer.curiosity.count import CellCounts
from curionav_cli.agents.lbs_dreamer.curiosity.curiosity import correlation, settled
from curionav_cli.agents.lbs_dreamer.curiosity.picture_count import KeyCounts
from curionav_cli.agents.lbs_dreamer.networks import initialise
from curionav_cli.agents.lbs_dreamer.optimiser import Optimiser
from curionav_cli.agents.lbs_dreamer.rssm import Observed, State
from curionav_cli.agents.lbs_dreamer.settings import Curiosity
from curionav_cli.agents.lbs_dreamer.world_model import Sequences
from curionav_cli.storage.replay import Replay

T, B, ACTIONS = 6, 3, 3
RSSM = SimpleNamespace(features=5, stoch=2, actions=ACTIONS)
LEARNED = [name for name in Curiosity.__members__ if name != "none"]


@pytest.fixture
def made():
    def make(name, burn_in=2):
        curiosity = kind(Curiosity(name))(RSSM, 16, 2, burn_in)
        initialise(curiosity, torch.Generator().manual_seed(0))
        return curiosity
    return make


@pytest.fixture
def seen():
    generator = torch.Generator().manual_seed(1)
    states = State(torch.randn(T, B, 3, generator=generator), torch.randn(T, B, 2, generator=generator))
    posterior, prior = (torch.randn(T, B, 2, 4, generator=generator) for _ in range(2))
    return Observed(states, posterior, prior)


@pytest.fixture
def data():
    action = torch.randint(0, ACTIONS, (T, B), generator=torch.Generator().manual_seed(2))
    visits = torch.randint(0, 9, (T, B), generator=torch.Generator().manual_seed(3)).float()
    return Sequences(torch.zeros(T, B, 0), action, torch.tensor([True, False, False]), visits)


@pytest.fixture
def imagined():
    generator = torch.Generator().manual_seed(5)
    return Imagined(torch.randn(4, 7, 5, generator=generator), torch.randint(0, ACTIONS, (3, 7), generator=generator))


@pytest.fixture
def noise():
    return torch.rand(T, B, generator=torch.Generator().manual_seed(4))


def surprise(seen):
    q, p = (Independent(OneHotCategorical(logits=x), 1) for x in (seen.posterior, seen.prior))
    return kl_divergence(q, p)


def where_settled(x):
    return torch.cat([x[:, 0], x[2:, 1], x[2:, 2]])


def test_every_file_is_a_choice_and_every_choice_a_file():
    files = {path.stem for path in Path(choose.__file__).parent.glob("*.py")} - {"__init__", "choose", "curiosity"}
    assert files == {kind(choice).__module__.rpartition(".")[2] for choice in Curiosity}


def test_the_first_steps_of_a_cut_out_sequence_are_not_settled():
    mask = settled(4, torch.tensor([True, False]), burn_in=2)
    assert mask.T.tolist() == [[True] * 4, [False, False, True, True]]


@pytest.mark.parametrize("name", Curiosity.__members__)
def test_reward_is_one_number_for_each_imagined_state_and_never_below_zero(made, imagined, name):
    wild = imagined._replace(features=10 * imagined.features)
    reward = made(name).intrinsic_reward(wild)
    assert reward.shape == (4, 7) and reward.dtype == torch.float32
    assert (reward >= 0).all() and bool(reward.any()) is (name != "none")


@pytest.mark.parametrize("name", LEARNED)
def test_no_gradient_reaches_the_world_model(made, seen, data, noise, name):
    leaves = [seen.states.deter, seen.states.stoch, seen.posterior, seen.prior]
    for leaf in leaves:
        leaf.requires_grad_()
    loss, _ = made(name).loss(seen.detach(), data, noise)
    assert loss.requires_grad and torch.autograd.grad(loss, leaves, allow_unused=True) == (None,) * 4


def test_lbs_learns_the_plain_kl_where_settled(made, seen, data, noise):
    lbs = made("lbs")
    loss, metrics = lbs.loss(seen, data, noise)
    target = surprise(seen)
    error = (lbs.head(torch.cat([seen.states.stoch, seen.states.deter], -1)).squeeze(-1) - target) ** 2
    torch.testing.assert_close(loss, where_settled(error).mean() / 2)
    torch.testing.assert_close(metrics["curiosity_target"], where_settled(target).mean())


def test_a_target_of_two_values_is_met_at_its_conditional_mean(made):
    """Two kinds of places; in one the KL is either 0 or log 4, at random."""
    generator, lbs = torch.Generator().manual_seed(2), made("lbs")
    kind = torch.arange(64) % 2
    features = State(torch.stack([kind, 1 - kind, torch.ones(64)], -1).float()[None], torch.zeros(1, 64, 2))
    data = Sequences(torch.zeros(1, 64, 0), torch.zeros(1, 64), torch.ones(64) > 0)
    optimiser = Optimiser(lbs, 0.01, 1e-5, 0.0, 100)
    for _ in range(300):
        sure = (torch.rand(1, 64, generator=generator) < 0.5) & (kind == 1)
        posterior = torch.zeros(1, 64, 1, 4)
        posterior[..., 0] = (sure * 50.0)[..., None]
        seen = Observed(features, posterior, torch.zeros_like(posterior))
        optimiser.step(lbs.loss(seen, data, torch.zeros(1, 64))[0])
    reward = lbs.intrinsic_reward(Imagined(features.features, torch.zeros(0, 64)))[0].detach()
    assert reward[kind == 0].mean() == pytest.approx(0.0, abs=0.08)
    assert reward[kind == 1].mean() == pytest.approx(torch.tensor(4.0).log().item() / 2, abs=0.15)


def test_lbs_count_is_the_kl_over_the_root_of_the_views_count(made, seen, data, noise):
    target = made("lbs_count").target(seen, data, noise)
    torch.testing.assert_close(target, surprise(seen) / data.counts.clamp(min=1).sqrt())


def test_shuffled_targets_are_those_of_lbs_in_other_places(made, seen, data, noise):
    there = surprise(seen)
    shuffled = made("shuffled").target(seen, data, noise)
    torch.testing.assert_close(where_settled(shuffled).sort()[0], where_settled(there).sort()[0])
    assert (where_settled(shuffled) != where_settled(there)).sum() > len(where_settled(there)) / 2
    torch.testing.assert_close(shuffled[:2, 1:].sort(0)[0].flatten().sort()[0], there[:2, 1:].flatten().sort()[0])


def test_every_settled_step_is_equally_likely_to_lend_its_target(made, seen, data):
    shuffled, there, generator = made("shuffled"), surprise(seen), torch.Generator().manual_seed(6)
    draws = torch.stack([shuffled.target(seen, data, torch.rand(T, B, generator=generator))[3, 1]
                         for _ in range(1400)])
    distance = (draws[:, None] - where_settled(there)).abs()  # 14 settled steps, 100 draws each
    assert distance.min(1).values.max() < 1e-5
    lent = distance.argmin(1).bincount(minlength=14)
    assert ((lent - 100.0) ** 2 / 100).sum() < 34.5  # chi-square, 13 degrees of freedom, p = 0.001


def test_count_learns_one_over_the_root_of_the_visits(made, seen, data, noise):
    target = made("count").target(seen, data, noise)
    torch.testing.assert_close(target, 1 / data.counts.clamp(min=1).sqrt())


def test_pictures_are_counted_by_their_keys_over_all_episodes(an_episode):
    def seen(*shades):
        image = np.zeros((len(shades), 64, 64, 3), np.uint8)
        image[:, ::2, :32] = 255  # keys tell shapes; shades turn them over
        image[np.array(shades) == 1] = 255 - image[np.array(shades) == 1]
        return replace(an_episode(len(shades) - 1), image=image)
    replay, pictures = Replay([seen(0, 1, 0, 0)]), KeyCounts()
    pictures.update(replay)
    replay.add(seen(1, 0))
    pictures.update(replay)
    pictures.update(replay)
    counts = pictures.of_windows(np.array([0, 1]), np.array([1, 0]), np.empty((2, 2, 3)))
    assert counts.dtype == np.float32
    assert counts.tolist() == [[2, 4], [2, 4]]


def test_visits_are_landings_on_cells_over_all_episodes(an_episode, a_plan):
    def walk(*places):
        pose = np.array([(x, y, 0.0) for x, y in places])
        return replace(an_episode(len(places) - 1), pose=pose)
    replay, visits = Replay([walk((0.1, 0.1), (0.6, 0.1), (0.1, 0.2))]), CellCounts(a_plan(4, 4, cell=0.5))
    visits.update(replay)
    replay.add(walk((0.1, 0.1), (1.9, 1.9)))
    visits.update(replay)
    visits.update(replay)
    pose = np.array([[[0.2, 0.2, 0.0], [0.7, 0.3, 1.0]], [[1.6, 1.6, 2.0], [1.1, 0.1, 3.0]]])
    assert visits.of_windows(None, None, pose).tolist() == [[3, 1], [1, 0]]


def test_rnd_forgets_its_surprise_where_it_has_learned(made, seen, data, noise):
    rnd = made("rnd", burn_in=0)
    frozen = [parameter.clone() for parameter in rnd.frozen.parameters()]
    optimiser = Optimiser(rnd, 0.01, 1e-5, 0.0, 100)
    elsewhere = Imagined(seen.states.features + 3, data.action)
    here = Imagined(seen.states.features, data.action)
    before, away = rnd.intrinsic_reward(here).mean(), rnd.intrinsic_reward(elsewhere).mean()
    for _ in range(200):
        optimiser.step(rnd.loss(seen, data, noise)[0])
    assert rnd.intrinsic_reward(here).mean() < before / 20
    assert rnd.intrinsic_reward(elsewhere).mean() > away / 5
    for parameter, was in zip(rnd.frozen.parameters(), frozen, strict=True):
        assert torch.equal(parameter, was)


def test_disagreement_is_the_variance_of_what_the_members_predict(made, imagined):
    ensemble = made("disagreement")
    reward = ensemble.intrinsic_reward(imagined)
    assert not reward[0].any()  # no action led to the first
    one_hot = torch.nn.functional.one_hot(imagined.action[1, 2], ACTIONS).float()
    x = torch.cat([imagined.features[1, 2], one_hot])
    predicted = np.stack([member(x).detach().numpy() for member in ensemble.members])
    assert reward[2, 2].item() == pytest.approx(predicted.var(0, ddof=1).mean(), rel=1e-5)


def test_members_learn_to_agree_on_what_follows(made, seen, data, noise):
    ensemble = made("disagreement", burn_in=0)
    optimiser = Optimiser(ensemble, 0.01, 1e-5, 0.0, 100)
    before, _ = ensemble.loss(seen, data, noise)
    for _ in range(300):
        optimiser.step(ensemble.loss(seen, data, noise)[0])
    after, metrics = ensemble.loss(seen, data, noise)
    assert after < before / 100 and metrics["curiosity_target"] < 1e-2


def test_correlation_is_pearsons_where_the_mask_is_one():
    x, y = torch.randn(2, 50, generator=torch.Generator().manual_seed(4))
    mask = (torch.arange(50) < 30).float()
    torch.testing.assert_close(correlation(x, y, mask), torch.corrcoef(torch.stack([x[:30], y[:30]]))[0, 1])
    assert correlation(torch.ones(50), y, mask) == 0
