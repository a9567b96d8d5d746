"""Files that hold timed messages by topic, whatever the messages mean."""
