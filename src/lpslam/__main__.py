"""`python -m lpslam`, and the command itself: Ctrl-C before anything is loaded is no traceback either."""

from lpslam.interruption import end, hold_streams, was_pressed, watch


def main() -> None:
    """Run the command line."""
    watch()
    hold_streams()
    try:
        from lpslam.cli import main as run_command

        run_command()
    except KeyboardInterrupt:
        end()
    except Exception:
        # A module that was broken off while it was loaded fails in its own way.
        if not was_pressed():
            raise
        end()


if __name__ == "__main__":
    main()
