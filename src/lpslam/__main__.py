"""`python -m lpslam`, and the command itself: Ctrl-C before anything is loaded is no traceback either."""

import sys


def main() -> None:
    """Run the command line."""
    try:
        from lpslam.cli import main as run_command

        run_command()
    except KeyboardInterrupt:
        sys.stderr.write("lpslam: interrupted\n")
        raise SystemExit(130) from None


if __name__ == "__main__":
    main()
