"""The fused encoder and decoder against the plain ones: values and gradients; wide layers stay with oneDNN."""

from types import SimpleNamespace

import pytest
import torch

pytest.importorskip("numba")

from curionav_cli.agents.lbs_dreamer.compile import fuse_images
from curionav_cli.agents.lbs_dreamer.kernels import fused_images
from curionav_cli.agents.lbs_dreamer.kernels.patches import to_byte_patches, to_patches
from curionav_cli.agents.lbs_dreamer.networks import Decoder, Encoder, initialise

N, FEATURES = 11, 9  # images, not a multiple of those at a time
SHAPES = {"scale=cpu": (([4, 5, 6], [4, 4, 4], [4, 2, 2]), ([5, 4], [7, 4, 4], [1, 2, 4])),
          "windows that overlap in every layer": (([4, 5, 6], [4, 4, 4], [2, 2, 2]), ([5, 4], [13, 6, 6], [2, 2, 2]))}


def networks(encoder, decoder):
    generator = torch.Generator().manual_seed(0)
    made = Encoder(*encoder), Decoder(FEATURES, 7, *decoder)
    for part in made:
        initialise(part, generator)
        with torch.no_grad():
            for parameter in part.parameters():
                parameter.add_((torch.rand(parameter.shape, generator=generator) - 0.5) / 2)
    return *made, generator


@pytest.mark.parametrize("shape", SHAPES)
def test_encoder_and_decoder_are_the_plain_ones_with_their_gradients(shape):
    encoder, decoder, generator = networks(*SHAPES[shape])
    image = torch.randint(0, 256, (N, 64, 64, 3), dtype=torch.uint8, generator=generator)
    features = torch.randn(N, FEATURES, generator=generator).requires_grad_()
    slope = torch.randn(N, encoder.size, generator=generator)
    patches, levels = to_patches(image, encoder.stride), to_byte_patches(image, encoder.stride)
    plain = encoder(patches), (decoder(features) - patches).square().sum() / N
    fused = fused_images.encoded(encoder, levels), fused_images.decoded_error(decoder, features, levels)
    wanted = [features, *encoder.parameters(), *decoder.parameters()]
    for one, other in zip(
            (*plain, *torch.autograd.grad((plain[0] * slope).sum() + 3 * plain[1], wanted)),
            (*fused, *torch.autograd.grad((fused[0] * slope).sum() + 3 * fused[1], wanted)), strict=True):
        torch.testing.assert_close(other, one, rtol=1e-4, atol=float(1e-5 * one.detach().abs().max()))


def test_wide_layers_are_left_as_they_are():
    encoder, decoder, _ = networks(([4, fused_images.MANY, 6], [4, 4, 4], [4, 2, 2]), SHAPES["scale=cpu"][1])
    model = SimpleNamespace(encoder=encoder, decoder=decoder)
    fuse_images(model)
    assert vars(model) == {"encoder": encoder, "decoder": decoder} and "forward" not in vars(encoder)
