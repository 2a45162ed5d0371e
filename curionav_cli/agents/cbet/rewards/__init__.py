"""The intrinsic reward: one file for each value of agent.reward. cbet.py is the paper's, reward.py the contract."""

from curionav_cli.agents.cbet.rewards.cbet import CBET
from curionav_cli.agents.cbet.rewards.count import Count
from curionav_cli.agents.cbet.rewards.count_oracle import CountOracle
from curionav_cli.agents.cbet.rewards.icm import ICM
from curionav_cli.agents.cbet.rewards.motion import Motion
from curionav_cli.agents.cbet.rewards.reward import Reward
from curionav_cli.agents.cbet.rewards.ride import RIDE
from curionav_cli.agents.cbet.rewards.rnd import RND

REWARDS: dict[str, type[Reward]] = {
    "cbet": CBET, "count": Count, "rnd": RND, "icm": ICM, "ride": RIDE, "motion": Motion,
    "count_oracle": CountOracle,
}
