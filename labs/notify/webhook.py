#!/usr/bin/env python3
"""Posts a print's end to a chat or a phone: notify.command = "python3 webhook.py URL [MEMBER]" (docs/notify.md).

The event comes as JSON on the standard input and goes to the URL as it is. With MEMBER, as chats want it, {MEMBER: sentence} goes
there instead: `text` for Slack and Mattermost, `content` for Discord.
"""
import json
import sys
import urllib.request

SECONDS = 30  # until a silent server is given up


def main():
    if len(sys.argv) not in (2, 3):
        sys.exit(__doc__)
    event = json.load(sys.stdin)
    body = {sys.argv[2]: event["text"]} if len(sys.argv) == 3 else event
    request = urllib.request.Request(sys.argv[1], json.dumps(body).encode(), {"Content-Type": "application/json"})
    with urllib.request.urlopen(request, timeout=SECONDS) as answer:
        answer.read()


main()
