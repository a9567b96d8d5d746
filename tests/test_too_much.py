"""What asks for more memory than there is."""

import numpy as np
import pytest

from lpslam.cli_runs import call_to_its_end


def test_too_little_memory_is_one_line(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as end:
        call_to_its_end(lambda: np.empty(1 << 62, np.uint8))
    assert end.value.code == 2
    assert capsys.readouterr().err == (
        "lpslam: there is not enough memory for that: ask for less, or for smaller values in --config\n"
    )
