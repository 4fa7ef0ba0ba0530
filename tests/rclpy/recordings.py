"""Test helper: reads recordings with a general MCAP reader, alters them, and runs `clearance replay`."""

import json
import subprocess

from mcap.reader import make_reader
from mcap.writer import Writer
from mcap_ros2.decoder import DecoderFactory

from node_process import BINARY

REPLAY_DEADLINE = 100.0  # [s] for a debug build on a busy machine


def replay(file, *arguments):
    """Runs a recording again: the finished process."""
    command = [BINARY, "replay", str(file), *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, timeout=REPLAY_DEADLINE)


def outcome(file, *arguments):
    """What came of it."""
    done = replay(file, "--format", "json", *arguments)
    assert done.returncode in (0, 1), done.stderr
    return json.loads(done.stdout)


def messages(file, topic):
    """All messages of a topic, as decoded by a reader that knows nothing of this node."""
    with open(file, "rb") as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()])
        return [message for _, _, _, message in reader.iter_decoded_messages(topics=[topic])]


def steps(file, node):
    return [json.loads(message.data) for message in messages(file, node.private("recording"))]


def tampered(file, copy, topic, number, change):
    """A copy in which `change` makes other bytes of those of one message of a topic, counted from 0."""
    with open(file, "rb") as stream, open(copy, "wb") as written:
        reader, writer = make_reader(stream), Writer(written)
        writer.start(profile="ros2", library="test")
        for attachment in reader.iter_attachments():
            times = attachment.create_time, attachment.log_time
            writer.add_attachment(*times, attachment.name, attachment.media_type, attachment.data)
        schemas, channels, seen = {}, {}, 0
        for schema, channel, message in reader.iter_messages(log_time_order=False):
            if schema.id not in schemas:
                schemas[schema.id] = writer.register_schema(schema.name, schema.encoding, schema.data)
            if channel.id not in channels:
                encoding = channel.message_encoding
                channels[channel.id] = writer.register_channel(channel.topic, encoding, schemas[schema.id])
            data = message.data
            if channel.topic == topic:
                data = change(data) if seen == number else data
                seen += 1
            writer.add_message(channels[channel.id], message.log_time, data, message.publish_time, message.sequence)
        writer.finish()
    assert seen > number
    return copy
