"""One learner in a process of its own: it updates or acts on request, and reports the cost.

    python benchmarks/learner_peers.py NAME JOB

JOB is JSON (learner_contenders.Job). Each line of stdin is a request, ["warm"], ["update", n], ["act", n],
["peaks"] or ["about"], and is answered by a line of JSON; learner.py asks. What each peer does more or less than
ours stands in RESULTS.md.
"""

from __future__ import annotations

import importlib.util
import json
import os
import sys
import time
from collections.abc import Callable
from importlib.metadata import version
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
from learner_contenders import ACTIONS, CPU, CUDA, Curionav, Job, Probe, Torch, batch, resident

LIGHTNING = {"float32": "32-true", "bfloat16": "bf16-mixed"}


class SheepRL(Torch):
    """sheeprl's DreamerV2: its train(), player and settings, but for the shapes; on a GPU compiled, as it offers."""

    packages = ("sheeprl", "torch")

    def __init__(self, job: Job):
        super().__init__(job)
        import gymnasium
        from lightning.fabric import Fabric
        from sheeprl.algos.dreamer_v2 import agent, dreamer_v2, utils

        cfg = sheeprl_settings(job)
        self.torch.set_float32_matmul_precision(cfg.float32_matmul_precision)  # these three as its command line does
        self.torch.backends.cudnn.benchmark = cfg.torch_backends_cudnn_benchmark
        self.torch.distributions.Distribution.set_default_validate_args(cfg.distribution.validate_args)
        fabric = Fabric(accelerator=job["device"], devices=1,
                        precision=LIGHTNING[job["precision"]])
        fabric.launch()
        space = gymnasium.spaces.Dict({"rgb": gymnasium.spaces.Box(0, 255, (3, 64, 64), np.uint8)})
        world, actor, critic, slow, self.player = agent.build_agent(fabric, [ACTIONS], False, cfg, space)
        optimisers = fabric.setup_optimizers(*(
            utils.build_optimizer(part.optimizer, module.parameters())
            for part, module in ((cfg.algo.world_model, world), (cfg.algo.actor, actor), (cfg.algo.critic, critic))))
        data = self.data(fabric.device)
        self.update = lambda: dreamer_v2.train(
            fabric, world, actor, critic, slow, *optimisers, dict(data), None, cfg, [ACTIONS])
        seen = {"rgb": data["rgb"][0, :1].cpu().numpy()}
        self.observe = lambda: utils.prepare_obs(fabric, seen, cnn_keys=["rgb"], num_envs=1)
        self.player.init_states()

    def data(self, device: Any) -> dict[str, Any]:
        """A batch as its buffer gives it, time first."""
        torch = self.torch
        image, action = (torch.from_numpy(part).transpose(0, 1) for part in batch(self.job["hyper"]))
        nothing = torch.zeros(*action.shape, 1, device=device)
        return {"rgb": image.permute(0, 1, 4, 2, 3).contiguous().to(device), "rewards": nothing,
                "actions": torch.nn.functional.one_hot(action, ACTIONS).float().to(device),
                "terminated": nothing, "is_first": nothing.clone()}

    def act(self) -> None:
        with self.torch.inference_mode():
            self.torch.cat(self.player.get_actions(self.observe()), -1).cpu().numpy().argmax()


def sheeprl_settings(job: Job) -> Any:
    """Its own configuration with our shapes."""
    from hydra import compose, initialize_config_module
    from omegaconf import OmegaConf
    from sheeprl.utils.utils import dotdict

    hyper, model = job["hyper"], "algo.world_model"
    changes = {
        "exp": "dreamer_v2", "env": "dummy", "env.num_envs": 1, "algo.mlp_keys.encoder": "[]",
        "algo.per_rank_batch_size": hyper["batch_size"], "algo.per_rank_sequence_length": hyper["sequence_length"],
        "algo.horizon": hyper["horizon"], "algo.dense_units": hyper["mlp_units"],
        "algo.mlp_layers": hyper["mlp_layers"], f"{model}.stochastic_size": hyper["latent_dimension"],
        f"{model}.discrete_size": hyper["latent_classes"],
        f"{model}.recurrent_model.recurrent_state_size": hyper["gru_units"],
        f"{model}.transition_model.hidden_size": hyper["rssm_hidden"],
        f"{model}.representation_model.hidden_size": hyper["rssm_hidden"],
        f"{model}.encoder.cnn_channels_multiplier": hyper["encoder_channels"][0],
        "algo.compile.enabled": job["device"] == CUDA,
        "fabric.precision": LIGHTNING[job["precision"]],
    }
    with initialize_config_module("sheeprl.configs", version_base="1.3"):
        composed = compose("config", [f"{key}={value}" for key, value in changes.items()])
    return dotdict(OmegaConf.to_container(composed, resolve=True))


class DreamerV2:
    """The original, in TensorFlow graphs, with its own KL reward (expl.ModelLoss) in place of the task's reward."""

    packages = ("dreamerv2", "tensorflow-cpu")
    clock = staticmethod(time.process_time)
    memory = staticmethod(resident)

    def __init__(self, job: Job):
        if job["device"] != CPU or job["precision"] != "float32":
            raise SystemExit("here only on a CPU and in float32: its half precision is for GPUs, and the pinned "
                             "tensorflow-cpu has none")
        tensorflow, package = old_tensorflow(), Path(importlib.util.find_spec("dreamerv2.agent").origin).parent
        sys.path.insert(0, str(package))
        original, common = importlib.import_module("agent"), importlib.import_module("common")
        box = SimpleNamespace
        spaces = {"image": box(shape=(64, 64, 3)), "reward": box(shape=()), "is_first": box(shape=())}
        settings = dreamerv2_settings(job, package / "configs.yaml", common.Config)
        learner = original.Agent(settings, spaces, {"action": box(n=ACTIONS, shape=(ACTIONS,))}, common.Counter(0))
        image, action = batch(job["hyper"])
        data = {"image": tensorflow.constant(image), "action": tensorflow.one_hot(action, ACTIONS),
                "reward": tensorflow.zeros(action.shape),
                **{key: tensorflow.zeros(action.shape, bool) for key in ("is_first", "is_terminal")}}
        self.update = tensorflow.function(lambda: dreamerv2_update(learner, data))
        seen, self.state = {key: value[:1, 0] for key, value in data.items()}, None
        self.step = lambda: learner.policy(seen, self.state, mode="explore")

    def act(self) -> None:
        outputs, self.state = self.step()
        outputs["action"].numpy().argmax()

    def warm(self) -> None:
        """The first update, which builds the graph; its operations are not counted."""
        self.update()


def dreamerv2_update(learner: Any, data: dict[str, Any]) -> None:
    """Agent.train without the actor and critic of the task."""
    _, seen, _ = learner.wm.train(data)
    learner._expl_behavior.train(seen["post"], seen, data)


def old_tensorflow() -> Any:
    """TensorFlow with the two names that the package expects of an older one."""
    os.environ["TF_CPP_MIN_LOG_LEVEL"] = "3"
    import tensorflow

    tensorflow.config.threading.set_intra_op_parallelism_threads(1)
    tensorflow.config.threading.set_inter_op_parallelism_threads(1)
    precision = importlib.import_module("tensorflow.keras.mixed_precision")
    precision.experimental = precision
    tensorflow.optimizers.Adam = tensorflow.keras.optimizers.legacy.Adam
    return tensorflow


def dreamerv2_settings(job: Job, path: Path, config: Callable[[Any], Any]) -> Any:
    """Its `dmc_vision` with our shapes; surprise for a reward, whose head is fitted to the KL."""
    from ruamel.yaml import YAML

    known, hyper = YAML(typ="safe").load(path.read_text()), job["hyper"]
    mlp = {"layers": hyper["mlp_layers"], "units": hyper["mlp_units"]}
    return config(known["defaults"]).update(known["dmc_vision"]).update({
        "expl_behavior": "ModelLoss", "grad_heads": ["decoder"], "imag_horizon": hyper["horizon"],
        "reward_norm.momentum": hyper["reward_momentum"],
        "rssm.stoch": hyper["latent_dimension"], "rssm.discrete": hyper["latent_classes"],
        "rssm.deter": hyper["gru_units"], "rssm.hidden": hyper["rssm_hidden"],
        **{f"{part}.cnn_depth": hyper["encoder_channels"][0] for part in ("encoder", "decoder")},
        **{f"{part}.{key}": value for part in ("reward_head", "expl_head", "actor", "critic")
           for key, value in mlp.items()}})


CONTENDERS = {"curionav": Curionav, "sheeprl": SheepRL, "dreamerv2": DreamerV2, "probe": Probe}


def answer(contender: Any, verb: str, times: int = 0) -> Any:
    """Seconds of one update or one step, the mean of `times`; or what is to be said about the contender."""
    if verb == "about":
        return {"memory": contender.memory(), "versions": [f"{name} {version(name)}" for name in contender.packages]}
    do = getattr(contender, verb)
    if not times:
        return do()
    begin = contender.clock()
    for _ in range(times):
        do()
    return (contender.clock() - begin) / times


def main(name: str, job: Job) -> None:
    answers = os.fdopen(os.dup(1), "w", buffering=1)
    os.dup2(2, 1)  # what the peers print does not stand among the answers
    contender = CONTENDERS[name](job)
    for line in sys.stdin:
        print(json.dumps(answer(contender, *json.loads(line))), file=answers)


if __name__ == "__main__":
    main(sys.argv[1], json.loads(sys.argv[2]))
