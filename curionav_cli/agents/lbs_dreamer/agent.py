"""LBS Dreamer, the agent of the paper: acts on filtered model states, learns in imagination.

Where its intrinsic reward comes from: curiosity/ (lbs.py, equation (2) of the paper), used in learner.py
(`update_behaviour`), which trains the actor and critic of behaviour.py on imagined rollouts.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import torch
from torch import Tensor

from curionav_cli.agents.agent import Agent
from curionav_cli.agents.device import ALL, keep_freed_memory, repeatable, resolve_device
from curionav_cli.agents.lbs_dreamer import settings as lbs_settings
from curionav_cli.agents.lbs_dreamer.behaviour import sample_action
from curionav_cli.agents.lbs_dreamer.checkpoint import load_learner, save_learner
from curionav_cli.agents.lbs_dreamer.compile import compile_mode, fuse_on, recorder
from curionav_cli.agents.lbs_dreamer.device_replay import DeviceReplay, room_on
from curionav_cli.agents.lbs_dreamer.kernels import latent
from curionav_cli.agents.lbs_dreamer.learner import Learner, build_networks
from curionav_cli.agents.lbs_dreamer.open_loop import predict_episode
from curionav_cli.agents.lbs_dreamer.planner import policy
from curionav_cli.agents.lbs_dreamer.probing import measure
from curionav_cli.agents.lbs_dreamer.rssm import State
from curionav_cli.agents.lbs_dreamer.world_model import Sequences
from curionav_cli.agents.meter import Meter, finite
from curionav_cli.agents.weights import load_weights, overwrite, pack, unpack
from curionav_cli.constants import IMAGE_SHAPE, Stream
from curionav_cli.errors import ConfigError, WeightsRefused
from curionav_cli.options import chosen
from curionav_cli.probe import Probe, Probed
from curionav_cli.records import Episode, FloorPlan, Prediction
from curionav_cli.storage.replay import NO_ACTION, Replay


class Step(NamedTuple):
    """Inputs of one step of acting (a named tuple, as CUDA graphs need it)."""

    image: Tensor  # (64, 64, 3) uint8
    action: Tensor  # (1,) int64, a_{t-1}
    deter: Tensor  # (1, D), h_{t-1}
    stoch: Tensor  # (1, S * C), z_{t-1}
    noise: Tensor  # (1, S + 1) uniform in [0, 1): the last number for the action
    planned: Tensor | None = None  # Policy.noise


class LBSDreamer(Agent):
    """DreamerV2's world model and actor-critic, with Latent Bayesian Surprise as the intrinsic reward.

    Random numbers: `rng` (numpy) draws windows of the replay, the learner's `generator` (torch) all else in learning,
    `acting_generator` the actions of one episode. That one is seeded by seed and episode alone, so that a robot and its
    server need not share a state. On a CPU the same seed and number of threads give the same bytes.
    """

    learns = has_model = True
    learner_class: type[Learner] = Learner

    def __init__(self, hyper: lbs_settings.LBSDreamer, seed: int, device: str, plan: FloorPlan,
                 compile: str = "auto"):
        super().__init__(seed)
        keep_freed_memory(kept=ALL, mapped_from=None)
        self.hyper, self.seed, self.device = hyper, seed, resolve_device(device)
        self.every = chosen(asdict(hyper))
        self.execution = self.every.execution()
        repeatable(self.device)
        mode = compile_mode(compile, self.device, hyper.precision)
        record = recorder(mode, self.device)
        weights_seed, learning_seed = (int(n) for n in self.rng.integers(2**62, size=2))
        networks = build_networks(hyper, torch.Generator().manual_seed(weights_seed), self.device)
        if mode == "fused":
            fuse_on(self.device, networks)
        generator = torch.Generator(self.device).manual_seed(learning_seed)
        self.learner = self.learner_class(hyper, networks, generator, record)
        self.visit_counts = networks.curiosity.visit_counts(plan)
        self.counts = self.visit_counts is not None
        self.policy = policy(networks, hyper)
        self.filter = record(self._filter, [])
        self.frames: DeviceReplay | None = None
        self.begin()

    @property
    def acting(self) -> tuple[str, ...]:
        """How the names of the networks begin that acting needs."""
        return "world_model.encoder.", "world_model.rssm.", self.policy.weights

    def begin(self) -> None:
        """Start an episode from a zero state, without an action before."""
        self.state = self.learner.networks.world_model.rssm.initial(1)
        self.action = torch.tensor([NO_ACTION], device=self.device)
        self.acting_generator: torch.Generator | None = None
        self.execution.begin()
        self.plans: list[Tensor] = []  # the planner's logits (1, A) of each choice

    def act(self, observation: dict[str, np.ndarray], info: dict[str, Any]) -> int:
        """Carry out the last choice to its end; then filter the image into the model state and draw another one."""
        if self.execution.due(info):
            outputs = self.filtered(observation, info["episode_index"])
            self.action = outputs["action"]
            self.execution.start(int(self.action))
        return self.execution.step()

    def filtered(self, observation: dict[str, np.ndarray], episode: int) -> dict[str, Tensor]:
        """Filter the image into the model state; what `_filter` gave. episode: its index over the whole run."""
        if self.acting_generator is None:
            seed = np.random.default_rng([self.seed, Stream.acting, episode]).integers(2**62)
            self.acting_generator = torch.Generator(self.device).manual_seed(int(seed))
        noise, planned = self._noise(partial(torch.rand, generator=self.acting_generator, device=self.device))
        outputs = self.filter(Step(torch.from_numpy(observation["image"]), self.action, *self.state, noise, planned))
        self.state = State(outputs["deter"], outputs["stoch"])
        if planned is not None:
            self.plans.append(outputs["logits"].clone())
        return outputs

    def report(self) -> dict[str, float]:
        """The mean entropy of planned choices in nats, of the last episode; `learn` reports that of the actor."""
        return {"plan_entropy": float(latent.entropy(torch.cat(self.plans)).mean())} if self.plans else {}

    @torch.inference_mode()
    def _filter(self, step: Step) -> dict[str, Tensor]:
        """s_t ~ q(s_t | s_{t-1}, a_{t-1}, x_t), then a_t ~ pi(a_t | s_t)."""
        networks = self.learner.networks
        model, rssm = networks.world_model, networks.world_model.rssm
        patches = model.patches(step.image.to(self.device))
        state, _ = rssm.filter(State(step.deter, step.stoch), rssm.action_input(step.action),
                               rssm.embed_input(model.encoder(patches)), step.noise[:, :-1])
        logits = self.policy.logits(state, step.planned)
        return {"deter": state.deter, "stoch": state.stoch, "logits": logits,
                "action": sample_action(logits, step.noise[:, -1])}

    def export_weights(self) -> bytes:
        """Return encoder, RSSM and what the policy needs as a safetensors file."""
        return pack(self.acting_weights())

    def import_weights(self, raw: bytes) -> None:
        """Act with exported weights. Raises WeightsRefused, and changes nothing, where they do not fit or not act."""
        own = self.acting_weights()
        before = {name: tensor.clone() for name, tensor in own.items()}
        overwrite(own, unpack(raw, own))
        if not self.acts_finitely():
            overwrite(own, before)
            raise WeightsRefused("they give no finite numbers for an image")

    @torch.inference_mode()
    def acts_finitely(self) -> bool:
        """Tell whether model state and policy are finite for a grey image."""
        grey = torch.full(IMAGE_SHAPE, 128, dtype=torch.uint8)
        action = torch.tensor([NO_ACTION], device=self.device)
        noise, planned = self._noise(lambda shape: torch.full(shape, 0.5, device=self.device))
        outputs = self.filter(Step(grey, action, *self.learner.networks.world_model.rssm.initial(1), noise, planned))
        return all(bool(tensor.isfinite().all()) for tensor in outputs.values())

    def _noise(self, drawn: Callable[[tuple[int, ...]], Tensor]) -> tuple[Tensor, Tensor | None]:
        """Random numbers of a step of acting, for the latents and the draw of an action, then for the policy."""
        own = drawn((1, self.hyper.latent_dimension + 1))
        return own, drawn(self.policy.noise) if self.policy.noise else None

    def acting_weights(self) -> dict[str, Tensor]:
        """The weights that acting needs, by name: the tensors themselves, not copies."""
        tensors = self.learner.networks.state_dict()
        return {name: tensor for name, tensor in tensors.items() if name.startswith(self.acting)}

    def predict(self, index: int, episode: Episode) -> Prediction | None:
        """Predict windows of the episode open-loop (open_loop.py); None where it is too short."""
        rng = np.random.default_rng([self.seed, Stream.predictions, index])
        return predict_episode(self.learner.networks, episode, self.hyper.sequence_length, rng, self.device, self.every)

    def probe(self, probe: Probe) -> Probed:
        """Measure the world model on a probe (probing.py)."""
        return measure(self.learner.networks.world_model, probe, self.device)

    def can_learn(self, replay: Replay) -> bool:
        """Whether an episode is as long as a training sequence."""
        return replay.holds(self.hyper.sequence_length)

    def learn(self, replay: Replay, iterations: int, tick: Callable[[int], None]) -> dict[str, float]:
        """K updates; returns the means of their metrics, and updates and frames since the run began.

        Raises ConfigError where no episode is as long as a training sequence, RunFailed where a loss or a gradient is
        not finite; the last checkpoint is then still good.
        """
        assert replay.every == self.every, (replay.every, self.every)
        meter = Meter()
        if self.visit_counts and iterations:
            self.visit_counts.update(replay)
        for iteration, data in enumerate(self._batches(replay, iterations)):
            meter.add(self.learner.update(data))
            tick(iteration + 1)
        metrics = finite(meter.read(), self.learner.updates, "agent.model_lr")
        updates, frames = float(self.learner.updates), self.hyper.batch_size * self.hyper.sequence_length
        totals = {"updates": updates, "frames_replayed": updates * frames}
        return {**metrics, **totals} if iterations else {}

    def save(self, folder: Path) -> None:
        """Write the files that checkpoint.py lists, and rng.json."""
        super().save(folder)
        save_learner(self.learner, folder)

    def load(self, folder: Path) -> None:
        """Restore what `save` wrote. Raises RunFolderError as `load_learner` does."""
        super().load(folder)
        load_learner(self.learner, folder)
        self.begin()

    def load_weights(self, folder: Path) -> None:
        """Take all networks from a checkpoint. Raises RunFolderError as weights.load_weights does."""
        load_weights(self.learner.networks, folder)
        self.begin()

    def _batches(self, replay: Replay, count: int) -> Iterator[Sequences]:
        """Draw `count` batches from the replay, time first, on the device.

        All are drawn at once, and all but their frames is copied at once, so that no update waits for the host.
        """
        if not count:
            return
        length = self.hyper.sequence_length
        try:
            drawn = [replay.draw(self.hyper.batch_size, length, self.rng) for _ in range(count)]
        except ValueError as error:
            raise ConfigError(
                f"no episode is long enough to learn from: a training sequence has {length} observations "
                f"(agent.sequence_length), so loop.steps must be at least {(length - 1) * self.every.most}.") from error
        all_which, all_start = (np.concatenate(part) for part in zip(*drawn, strict=True))
        moves = replay.moves(all_which, all_start, length)  # (count * B, L)
        parts = [moves["action"].T, moves["is_start"]]
        if self.visit_counts:
            parts.append(self.visit_counts.of_windows(all_which, all_start, moves["pose"]).T)
        parts = [torch.from_numpy(part).to(self.device).split(self.hyper.batch_size, -1) for part in parts]
        if self.frames is None or self.frames.replay is not replay:
            self.frames = DeviceReplay(replay, self.device, room_on(self.device))
        self.frames.follow()
        for (which, start), *others in zip(drawn, *parts, strict=True):
            yield Sequences(self.frames.windows(which, start, length), *others)
