"""A real robot behind topics and actions: the environment of env=live robot=rosbridge."""
