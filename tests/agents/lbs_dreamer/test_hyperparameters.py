"""scale=paper is the paper's table, number by number; wrong numbers are refused by name."""

import json
from pathlib import Path

import pytest

from curionav_cli.agents.lbs_dreamer import settings as lbs_settings

TABLE = json.loads((Path(__file__).parent / "paper_table.json").read_text())
KEYS = {
    "Batch size": "batch_size", "Batch sequence length": "sequence_length",
    "Discrete latent state dimension": "latent_dimension", "Discrete latent classes": "latent_classes",
    "GRU cell dimension": "gru_units", "KL free nats": "free_nats", "KL balancing": "kl_balance",
    "World model Adam learning rate": "model_lr", "Slow critic update interval": "slow_critic_interval",
    "Imagination horizon": "horizon", "gamma parameter": "gamma", "lambda parameter": "return_lambda",
    "Actor-critic Adam learning rate": ("actor_lr", "critic_lr"), "Actor entropy loss scale": "entropy",
    "MLP number of layers": "mlp_layers", "MLP number of units": "mlp_units",
    "Hidden layers dimension": "mlp_units", "Adam epsilon": "adam_epsilon", "Weight decay": "weight_decay",
    "Gradient clipping": "clip",
}


@pytest.mark.parametrize("name", TABLE)
def test_paper_scale_is_the_papers_table(hyper, name):
    keys = KEYS[name] if isinstance(KEYS[name], tuple) else (KEYS[name],)
    assert [getattr(hyper("paper"), key) for key in keys] == [TABLE[name]] * len(keys)


def test_both_scales_have_every_setting_and_nothing_else(hyper):
    settings = lbs_settings.LBSDreamer.__dataclass_fields__.keys()
    assert vars(hyper("paper")).keys() == vars(hyper("cpu")).keys() == settings


@pytest.mark.parametrize("key, value, message", [
    ("batch_size", 0, "agent.batch_size: 0 is not between 1 and"),
    ("gamma", 1.5, "agent.gamma: 1.5 is not between 0 and 1"),
    ("encoder_kernels", [4, 4], "agent.encoder_channels: two layers"),
    ("decoder_kernels", [5, 5, 6, 8], "agent.decoder_kernels: .* side 66, not 64"),
    ("encoder_strides", [4, 2, 2, 2], "agent.encoder_strides: the first must be the last"),
    ("clip", 0.0, "agent.clip"),
])
def test_impossible_numbers_are_refused_by_name(hyper, key, value, message):
    with pytest.raises(Exception, match=message):
        hyper("paper", **{key: value})
