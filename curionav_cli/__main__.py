"""Run the command line as python -m curionav_cli."""

from curionav_cli.app import main

if __name__ == "__main__":
    main()
