"""C-BET (Parisi et al., NeurIPS 2021), its siblings and controls: one learner, one small file a reward."""
