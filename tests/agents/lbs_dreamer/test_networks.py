"""Encoder and decoder against torch's own layers, and the published numbers of parameters."""

import pytest
import torch
import torch.nn.functional as F

from curionav_cli.agents.lbs_dreamer.kernels.patches import to_patches
from curionav_cli.agents.lbs_dreamer.networks import Decoder, Encoder, initialise

DREAMER = ([4, 4, 4, 4], [2, 2, 2, 2]), ([5, 5, 6, 6], [2, 2, 2, 2])
PATCHES = ([4, 4, 4], [4, 2, 2]), ([7, 4, 4], [1, 2, 4])


@pytest.fixture
def image():
    generator = torch.Generator().manual_seed(0)
    return torch.randint(0, 256, (2, 64, 64, 3), dtype=torch.uint8, generator=generator)


def ready(network):
    initialise(network, torch.Generator().manual_seed(0))
    with torch.no_grad():
        for layer in network.layers:
            layer.bias.uniform_(-1, 1, generator=torch.Generator().manual_seed(1))
    return network.double()


@pytest.mark.parametrize("kernels, strides", [DREAMER[0], PATCHES[0]])
def test_encoder_on_patches_is_plain_convolutions_on_pixels(image, kernels, strides):
    encoder = ready(Encoder([4, 6, 8, 8][:len(kernels)], kernels, strides))
    ours = encoder(to_patches(image, strides[0]).double())
    x = (to_patches(image, 1).double()).permute(0, 3, 1, 2)
    for layer in encoder.layers:
        x = F.elu(layer(x))
    truth = x.permute(0, 2, 3, 1).flatten(1)
    assert ours.shape == (2, encoder.size)
    torch.testing.assert_close(ours, truth, atol=1e-6, rtol=1e-6)
    gradients = [torch.autograd.grad(y.square().sum(), tuple(encoder.parameters())) for y in (ours, truth)]
    torch.testing.assert_close(*gradients, atol=1e-5, rtol=1e-5)


@pytest.mark.parametrize("kernels, strides", [DREAMER[1], PATCHES[1]])
def test_decoder_to_patches_is_plain_transposed_convolutions(kernels, strides):
    decoder = ready(Decoder(10, 6, [8, 6, 4][:len(kernels) - 1], kernels, strides))
    features = torch.randn(2, 10, dtype=torch.float64, generator=torch.Generator().manual_seed(2))
    ours, side = decoder(features), strides[-1]
    x = decoder.dense(features)[:, :, None, None]
    for layer in decoder.layers[:-1]:
        x = F.elu(layer(x))
    truth = decoder.layers[-1](x).permute(0, 2, 3, 1)
    truth = truth.reshape(2, 64 // side, side, 64 // side, side, 3).transpose(2, 3).reshape(ours.shape)
    torch.testing.assert_close(ours, truth)
    gradients = [torch.autograd.grad(y.square().sum(), tuple(decoder.parameters())) for y in (ours, truth)]
    torch.testing.assert_close(*gradients)


def count(module):
    return sum(parameter.numel() for parameter in module.parameters())


def test_paper_scale_has_the_published_number_of_parameters(hyper, networks):
    made = networks(hyper("paper"))
    model = made.world_model
    assert model.encoder.size == 1536 and model.rssm.features == 1224
    layers = {name: count(layer) for name, layer in model.rssm.named_children()}
    assert layers == {"img_in": 205_600, "gru": 240_600, "gru_norm": 1_200, "img_out": 40_200,
                      "img_dist": 205_824, "obs_out": 347_400, "obs_dist": 205_824}
    assert count(model.encoder) == 1_551_312
    assert (count(model.rssm), count(model.decoder)) == (1_246_648, 9_886_611)
    assert count(model) == 12_684_571
    heads = made.curiosity, made.behaviour.critic, made.behaviour.slow_critic
    assert [count(head) for head in heads] == [971_601] * 3
    assert count(made.behaviour.actor) == 972_403
    assert count(made) - count(made.behaviour.slow_critic) == 15_600_176


def test_initial_weights_are_glorot_uniform_with_zero_bias(tiny, networks):
    layer = networks(tiny()).world_model.rssm.obs_out
    bound = (6 / (layer.in_features + layer.out_features)) ** 0.5
    assert 0.9 * bound < layer.weight.abs().max() <= bound
    assert not layer.bias.any()
