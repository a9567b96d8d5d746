"""Limits of the servers: what one client, one question and one upload may cost."""

from lpslam.config.section import Field, Section


class JobsConfig(Section):
    """Uploads of recordings, which are mapped in processes of their own."""

    # Bytes of one upload: an hour of RGB-D at 30 frames/s is about 30 GB, minutes are what one sends.
    upload_bytes: int = Field(default=4 << 30, ge=1)
    # Seconds without a byte after which an upload is given up: a sender that drips holds a place.
    silence_s: float = Field(default=30.0, gt=0)
    # Bytes that an archive may unpack to, ...
    unpacked_bytes: int = Field(default=16 << 30, ge=1)
    # ... and as a multiple of its own size: pictures hardly shrink, bombs shrink a thousandfold.
    unpacked_ratio: float = Field(default=50.0, ge=1)
    # Bytes that need no such ratio: lists of small recordings shrink well.
    free_bytes: int = Field(default=64 << 20, ge=0)
    # Files in an archive: an hour has 216,000 pictures.
    files: int = Field(default=300_000, ge=1)
    # Uploads that may wait or run; more are told to come back.
    waiting: int = Field(default=4, ge=1)
    # Finished jobs that are remembered.
    remembered: int = Field(default=100, ge=1)
    # Bytes that must stay free on the disk.
    spare_disk_bytes: int = Field(default=1 << 30, ge=0)
    # Bytes of memory of a job's process, as addresses; the reading engine reserves more than it uses.
    memory_bytes: int = Field(default=12 << 30, ge=1 << 28)
    # Seconds of processor time, ...
    processor_s: int = Field(default=4 * 3600, ge=1)
    # ... and by the clock.
    clock_s: float = Field(default=6 * 3600.0, gt=0)
    # Bytes of one file that a job writes.
    file_bytes: int = Field(default=8 << 30, ge=1 << 20)


class WatchingConfig(Section):
    """A map that is watched while it grows: how often its page is told what."""

    # Share of one core that each kind of news may cost on average: of watching as a whole, a few percent.
    share: float = Field(default=0.01, gt=0.0, le=1.0)
    # Seconds between two positions of the camera: five a second look like motion.
    state_s: float = Field(default=0.2, gt=0.0)
    # Seconds between two looks at the landmarks after news of them; without news five times as many.
    signs_s: float = Field(default=1.0, gt=0.0)
    # Seconds between two tellings of the camera's way and of what keyframes saw.
    ground_s: float = Field(default=2.0, gt=0.0)
    # Events that are told: as many as anyone reads; older ones are counted.
    events: int = Field(default=100, ge=1)
    # Scans of keyframes that are told at once, of 100 KB each.
    scans: int = Field(default=20, ge=1)
    # Share of one core, in the page's process and behind tracking, that the room's pictures and points may cost.
    painting_share: float = Field(default=0.01, gt=0.0, le=1.0)
    # Seconds between two pictures of the room, or two lots of new points.
    picture_s: float = Field(default=3.0, gt=0.0)


class ServingConfig(Section):
    """What one client may ask for."""

    # Bytes of a request that is no upload: the longest question in any script is a tenth of it.
    body_bytes: int = Field(default=64 << 10, ge=1024)
    # Letters of a question that is taken at all; what is read of it is `language.question_length`.
    question_letters: int = Field(default=4000, ge=1)
    # Seconds in which a request must have come in.
    request_s: float = Field(default=10.0, gt=0)
    # Requests a second of one client (a token, or an address without), and how many may come at once.
    rate: float = Field(default=400.0, gt=0)
    burst: float = Field(default=800.0, ge=1)
    # Refused tokens a minute of one address: guessing is slow, mistyping is not punished.
    refusals_a_minute: float = Field(default=30.0, gt=0)
    # Clients whose rates are kept; the one that was silent longest goes first.
    clients: int = Field(default=10_000, ge=1)
    # Connections at once.
    connections: int = Field(default=512, ge=1)
    # Questions that may wait for an answer; more are told to come back.
    waiting_questions: int = Field(default=128, ge=1)
    # Seconds after which a question's answer is given up.
    answer_s: float = Field(default=30.0, gt=0)
    # Answers that are kept for who asks the same of the same version of a map; 2 KB each.
    answers_kept: int = Field(default=2000, ge=0)
    # Landmarks on a page at most, ...
    page_size: int = Field(default=200, ge=1)
    # ... and where nobody says.
    usual_page_size: int = Field(default=50, ge=1)
    # Listeners to events at once, ...
    listeners: int = Field(default=64, ge=1)
    # ... and events that wait for one; of a slow listener's the oldest are dropped.
    waiting_events: int = Field(default=256, ge=1)
    # Seconds between signs of life to listeners.
    heartbeat_s: float = Field(default=15.0, gt=0)
    # Seconds between looks at whether a map's file was replaced.
    look_s: float = Field(default=1.0, gt=0)
    jobs: JobsConfig = JobsConfig()
    watching: WatchingConfig = WatchingConfig()
