#!/usr/bin/env python3
"""Sends a print's end as mail: notify.command = "python3 mail.py SERVER[:PORT] FROM TO..." (docs/notify.md).

The event comes as JSON on the standard input. The server must take mail of this computer; STARTTLS is used where it offers it.
"""
import email.message
import json
import smtplib
import sys

SECONDS = 30  # until a silent server is given up


def main():
    if len(sys.argv) < 4:
        sys.exit(__doc__)
    server, sender, *receivers = sys.argv[1:]
    event = json.load(sys.stdin)
    mail = email.message.EmailMessage()
    mail["Subject"] = f"[firn] {event['text'].splitlines()[0][:200]}"
    mail["From"], mail["To"] = sender, ", ".join(receivers)
    mail.set_content("\n".join(f"{name}: {value}" for name, value in event.items() if value not in (None, "")))
    host, _, port = server.partition(":")
    with smtplib.SMTP(host, int(port or 25), timeout=SECONDS) as to:
        if to.ehlo()[0] == 250 and to.has_extn("starttls"):
            to.starttls()
        to.send_message(mail)


main()
