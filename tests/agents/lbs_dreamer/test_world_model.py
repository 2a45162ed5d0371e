"""The world model as a whole: its loss, the share of frames it decodes, overfitting one batch."""

import pytest
import torch

from curionav_cli.agents.lbs_dreamer.learner import Learner
from curionav_cli.agents.lbs_dreamer.world_model import choose


def noise(*shape, seed=0):
    return torch.rand(shape, generator=torch.Generator().manual_seed(seed))


def test_the_loss_is_minus_the_log_likelihood_but_for_a_constant(tiny, networks, data):
    model = networks(tiny(decoded_share=1.0, free_nats=0.0)).world_model
    loss, seen, metrics = model.loss(data, noise(8, 3, 4), noise(24))
    decoded = model.decoder(seen.states.features.flatten(0, 1))
    normal = torch.distributions.Normal(decoded, 1.0)
    likelihood = normal.log_prob(model.patches(data.image)).flatten(1).sum(-1).mean()
    constant = 64 * 64 * 3 * 0.5 * torch.log(torch.tensor(2 * torch.pi))
    q, p = (torch.distributions.Categorical(logits=x) for x in (seen.posterior, seen.prior))
    surprise = torch.distributions.kl_divergence(q, p).sum(-1).mean()
    torch.testing.assert_close(loss, surprise - likelihood - constant, rtol=1e-4, atol=1e-2)
    torch.testing.assert_close(metrics["image_mse"] * 64 * 64 * 3 / 2, metrics["image_loss"])


def test_a_share_of_the_frames_is_chosen_without_repeats():
    chosen = choose(10, 4, noise(10))
    assert len(set(chosen.tolist())) == 4 and chosen.max() < 10
    assert choose(10, 10, noise(10)) == slice(None)


def test_decoding_a_share_estimates_the_whole(tiny, networks, data):
    model = networks(tiny(decoded_share=0.25)).world_model
    parts = [model.loss(data, noise(8, 3, 4), noise(24, seed=s))[2]["image_mse"] for s in range(40)]
    model.decoded = 24
    whole = model.loss(data, noise(8, 3, 4), noise(24))[2]["image_mse"]
    assert torch.stack(parts).mean().item() == pytest.approx(whole.item(), rel=0.1)
    assert torch.stack(parts).std() > 0


def test_bfloat16_agrees_with_float32(tiny, networks, data):
    model = networks(tiny()).world_model
    full = model.loss(data, noise(8, 3, 4), noise(24))[0]
    with torch.autocast("cpu", torch.bfloat16):
        half, seen, _ = model.loss(data, noise(8, 3, 4), noise(24))
        drawn = model.decoder(seen.states.features.flatten(0, 1)).float()
    assert half.dtype == torch.float32
    # Frames and squared errors are float32, which beside bfloat16 is exact. What is drawn went through twelve layers,
    # each of which rounds three times by 2^-8 at most (inputs, weights, sums), independently of each other; a squared
    # error changes by twice that, in the share that what is drawn has in it.
    share = drawn.norm() / (2 * full * len(drawn))**0.5
    torch.testing.assert_close(half, full, rtol=float(2 * 2.0**-8 * (3 * 12)**0.5 * share.detach()), atol=0)


def test_one_batch_is_overfitted_and_predicted_from_its_first_frames(tiny, networks, data):
    settings = tiny(gru_units=48, rssm_hidden=48, latent_dimension=8, latent_classes=8, model_lr=3e-3,
                    encoder_channels=[8, 16, 16], decoder_channels=[16, 8], decoded_share=1.0)
    learner = Learner(settings, networks(settings), torch.Generator().manual_seed(1))
    losses = [learner.update_world_model(data, learner.draw(data.action.shape, False))[1] for _ in range(350)]
    decoded = learner.networks.world_model.predict(data.image, data.action, 8, noise(8, 3, 8)).flatten(2).float()
    off = (decoded[:, :, None] - data.image.flatten(2)[:, None].float()).square().mean(-1).sqrt()  # (T, B, B)
    own = off.diagonal(dim1=1, dim2=2)
    assert own.max() < 6 and own.mean() < 3  # of 255 levels: to the eye they are the same pictures
    assert (own <= off.min(-1).values).all()  # and no other sequence's picture of that step is nearer
    assert losses[-1]["image_mse"] < losses[0]["image_mse"] / 10
    assert losses[-1]["posterior_entropy"] < losses[0]["posterior_entropy"]
    predicted = learner.networks.world_model.predict(data.image, data.action, 3, noise(8, 3, 8))
    truth, ours, last = (x.float() for x in (data.image[3:], predicted[3:], data.image[2:3]))
    assert (ours - truth).square().mean() < 0.7 * (last - truth).square().mean()
