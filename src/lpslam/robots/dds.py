"""A bus over DDS (Eclipse Cyclone DDS), with the names, types and bytes that ROS 2 has there; ROS itself is not needed.

Names: https://design.ros2.org/articles/topic_and_service_names.html. Requests and replies carry a client's number and
a count before them, as rmw_cyclonedds sends them; other RMWs keep these elsewhere.
"""

import functools
import itertools
import logging
import struct
import threading
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from typing import Any

from cyclonedds.core import DDSException, InstanceState, ReadCondition, SampleState, ViewState, WaitSet
from cyclonedds.domain import Domain, DomainParticipant
from cyclonedds.idl import make_idl_struct
from cyclonedds.idl import types as idl_types
from cyclonedds.pub import DataWriter
from cyclonedds.qos import Policy, Qos
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.util import duration
from rosbags.interfaces import Nodetype

from lpslam.errors import UserError
from lpslam.robots.bus import OnBytes, Send
from lpslam.robots.types import BadBytesError, dds_topic, dds_type, decoded, encoded, request_of, response_of, store

logger = logging.getLogger(__name__)

idl: Any = idl_types  # its generics are made at run time
HERE = "127.0.0.1"
_ON_THIS_MACHINE = f"""<CycloneDDS><Domain>
  <General>
    <Interfaces><NetworkInterface address="{HERE}"/></Interfaces><AllowMulticast>false</AllowMulticast>
  </General>
  <Discovery>
    <ParticipantIndex>auto</ParticipantIndex><MaxAutoParticipantIndex>32</MaxAutoParticipantIndex>
    <Peers><Peer address="{HERE}"/></Peers>
  </Discovery>
</Domain></CycloneDDS>"""
"""As ROS_LOCALHOST_ONLY=1 makes it: no packet leaves the machine. Cyclone's sockets hear any address all the same."""
_DEPTH = 10
"""Messages that wait to be taken."""
_WAIT = 0.1
"""Seconds between two questions whether to stop."""
_AGAIN = 2.0
"""Seconds after which a request is sent once more."""
_HEAD = struct.Struct("<Qq")
"""A client's number and a count of requests."""
_CDR_HEAD = 4
_PLAIN = {
    **{name: getattr(idl, name) for name in ("uint8", "int8", "uint16", "int16", "uint32", "int32", "uint64", "int64")},
    **{"float32": idl.float32, "float64": idl.float64, "bool": bool, "string": str, "byte": idl.uint8},
}


class DdsBus:
    """A `Bus` of one participant.

    Args:
        domain: number of the DDS domain, ROS_DOMAIN_ID.
        on_this_machine: whether no packet leaves the machine; else as CYCLONEDDS_URI says.

    Raises:
        UserError: there is no such domain, or no network for it.
    """

    def __init__(self, domain: int = 0, *, on_this_machine: bool = True) -> None:
        self._config: Any = None
        try:
            # A second one of a domain in the same process has the first one's settings.
            with suppress(DDSException):
                self._config = Domain(domain, _ON_THIS_MACHINE) if on_this_machine else None
            self._participant = DomainParticipant(domain)
        except DDSException as error:
            raise UserError(f"DDS domain {domain} cannot be joined ({error.msg or error.code})") from error
        self._waitset = WaitSet(self._participant)
        self._readers: list[tuple[Any, Any, OnBytes]] = []
        self._adding = threading.Lock()
        self._answering = ThreadPoolExecutor(1, thread_name_prefix="service")
        self._stopped = threading.Event()
        self._thread = threading.Thread(target=self._listen, name="dds", daemon=True)
        self._thread.start()

    def publisher(self, topic: str, kind: str, *, latched: bool = False) -> Send:
        """See `Bus`."""
        write = self._writer(dds_topic(topic), _raw(kind), latched)
        return lambda message: write(encoded(message))

    def subscribe(
        self, topic: str, kind: str, on_bytes: OnBytes, *, latched: bool = False, reliable: bool = False
    ) -> None:
        """See `Bus`."""
        self._read(dds_topic(topic), _raw(kind), on_bytes, latched, reliable or latched)

    def serve(self, name: str, service: str, respond: Callable[[Any], Any]) -> None:
        """See `Bus`."""
        request, response = request_of(service), response_of(service)
        reply = self._writer(dds_topic(f"{name}Reply", "rr"), _raw(response, True), False)

        def answer(data: bytes) -> None:
            try:
                head, asked = _unwrapped(data, request)
            except BadBytesError as error:
                logger.warning("%s: %s", name, error)
                return
            reply(_wrapped(head, respond(asked)))

        def answer_later(data: bytes) -> None:
            self._answering.submit(_logged, answer, data, name)

        self._read(dds_topic(f"{name}Request", "rq"), _raw(request, True), answer_later, False, True)

    def client(self, name: str, service: str) -> Callable[[Any, float], Any]:
        """A function that calls a service: with a request and seconds; None where no response comes in time."""
        number, count = id(self) & 0xFFFFFFFF, itertools.count(1)
        replies: dict[bytes, Any] = {}
        came = threading.Condition()

        def take(data: bytes) -> None:
            with suppress(BadBytesError):
                head, reply = _unwrapped(data, response_of(service))
                with came:
                    replies[head] = reply
                    came.notify_all()

        self._read(dds_topic(f"{name}Reply", "rr"), _raw(response_of(service), True), take, False, True)
        ask = self._writer(dds_topic(f"{name}Request", "rq"), _raw(request_of(service), True), False)

        def call(request: Any, seconds: float) -> Any:
            head = _HEAD.pack(number, next(count))
            until = time.monotonic() + seconds
            with came:
                replies.clear()
                while head not in replies and (left := until - time.monotonic()) > 0:
                    # Who was not there yet has not heard it; a service may so be asked twice.
                    ask(_wrapped(head, request))
                    came.wait(min(left, _AGAIN))
                return replies.get(head)

        return call

    def close(self) -> None:
        """See `Bus`."""
        self._stopped.set()
        self._thread.join(timeout=5.0)
        self._answering.shutdown(cancel_futures=True)

    def _writer(self, name: str, kind: Any, latched: bool) -> Callable[[bytes], None]:
        topic = Topic(self._participant, name, kind)
        writer = DataWriter(self._participant, topic, _quality(latched, True))

        def write(data: bytes) -> None:
            try:
                writer.write(kind.of(data))
            except DDSException as error:
                logger.warning("%s: a message could not be sent (%s)", name, error.msg)

        return write

    def _read(self, name: str, kind: Any, on_bytes: OnBytes, latched: bool, reliable: bool) -> None:
        topic = Topic(self._participant, name, kind)
        reader = DataReader(self._participant, topic, _quality(latched, reliable))
        unread = ReadCondition(reader, SampleState.NotRead | ViewState.Any | InstanceState.Any)
        with self._adding:
            self._readers.append((reader, unread, on_bytes))
            self._waitset.attach(unread)

    def _listen(self) -> None:
        while not self._stopped.is_set():
            with suppress(DDSException):
                self._waitset.wait(duration(seconds=_WAIT))
            with self._adding:
                readers = list(self._readers)
            for reader, _, on_bytes in readers:
                try:
                    taken = reader.take(_DEPTH)
                except Exception as error:  # what came over the network may be anything
                    logger.warning("a message could not be taken (%s)", type(error).__name__)
                    continue
                for sample in taken:
                    if hasattr(sample, "cdr") and not self._stopped.is_set():
                        _logged(on_bytes, sample.cdr, reader.topic.name)


class _Raw:
    """Bytes in place of fields: ROS's types have the same ones in DDS, and rosbags reads and writes them."""

    cdr: bytes

    @classmethod
    def of(cls, data: bytes) -> "_Raw":
        sample = cls.__new__(cls)
        sample.cdr = data
        return sample

    def serialize(self, *_: Any, **__: Any) -> bytes:
        return self.cdr

    @classmethod
    def deserialize(cls, data: bytes, *_: Any, **__: Any) -> "_Raw":
        return cls.of(bytes(data))


@functools.cache
def _raw(kind: str, is_wrapped: bool = False) -> Any:
    """The type in DDS of a type of ROS, whose samples are bytes."""
    made = _struct(kind, is_wrapped)
    for name in ("of", "deserialize"):
        setattr(made, name, classmethod(getattr(_Raw, name).__func__))
    made.serialize = _Raw.serialize
    return made


@functools.cache
def _struct(kind: str, is_wrapped: bool = False) -> Any:
    fields: dict[str, Any] = {"client": idl.uint64, "count": idl.int64} if is_wrapped else {}
    fields |= {name: _field(node) for name, node in store().fielddefs[kind][1]}
    name = dds_type(kind)
    return make_idl_struct(name.rpartition("::")[2], name.replace("::", "."), fields)


def _field(node: Any) -> Any:
    """The IDL type of a field as rosbags describes it."""
    what, detail = node
    if what == Nodetype.BASE:
        name, limit = detail
        return idl.bounded_str[limit] if name == "string" and limit else _PLAIN[name]
    if what == Nodetype.NAME:
        return _struct(detail)
    inner, size = detail
    if what == Nodetype.ARRAY:
        return idl.array[_field(inner), size]
    return idl.sequence[_field(inner), size] if size else idl.sequence[_field(inner)]


def _quality(latched: bool, reliable: bool) -> Any:
    return Qos(
        Policy.Reliability.Reliable(duration(seconds=1)) if reliable else Policy.Reliability.BestEffort,
        Policy.Durability.TransientLocal if latched else Policy.Durability.Volatile,
        Policy.History.KeepLast(1 if latched else _DEPTH),
        # ROS 2 speaks the first version of CDR.
        Policy.DataRepresentation(use_cdrv0_representation=True),
    )


def _wrapped(head: bytes, message: Any) -> bytes:
    """A request or a reply: sixteen bytes stand before its fields, which stay aligned."""
    data = encoded(message)
    return data[:_CDR_HEAD] + head + data[_CDR_HEAD:]


def _unwrapped(data: bytes, kind: str) -> tuple[bytes, Any]:
    end = _CDR_HEAD + _HEAD.size
    return data[_CDR_HEAD:end], decoded(data[:_CDR_HEAD] + data[end:], kind)


def _logged(call: OnBytes, data: bytes, name: str) -> None:
    """Nothing that one message does ends the thread that takes all."""
    try:
        call(data)
    except Exception:
        logger.exception("%s: a message could not be handled", name)
