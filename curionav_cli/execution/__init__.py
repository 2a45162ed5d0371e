"""How a run or a sweep is carried out: launch, record, interrupt, resume."""
