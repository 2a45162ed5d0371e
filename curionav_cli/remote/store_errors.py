"""Why a storage failed, in our own words, because obstore's errors quote requests and answers of the server."""

from __future__ import annotations

import re

from curionav_cli.errors import Denied, Unreachable

REASONS = (  # the first whose pattern is found
    (Denied, r"RequestTimeTooSkewed|RequestExpired|difference between the request time",
     "it says that this machine's clock is wrong: set it"),
    (Denied, r"Error parsing Path|InvalidPath|parse path",
     "it holds an object with a name that leads elsewhere: remove that"),
    (Denied, r"NoSuchBucket", "it has no such bucket"),
    (Unreachable, r"No space left|os error 28\b|StorageFull|Quota|QuotaExceeded|InsufficientStorage|\b507\b",
     "it is full"),
    (Denied, r"InvalidAccessKeyId|SignatureDoesNotMatch|AccessDenied|InvalidToken|ExpiredToken|Unauthenticated"
             r"|\b40[13] ", "it refuses our key"),
    (Denied, r"169\.254\.169\.254|169\.254\.170\.2|CredentialProvider|InstanceCredential", "there is no key for it"),
    (Unreachable, r"ConnectionRefused|Connection refused", "the connection was refused"),
    (Unreachable, r"dns error|failed to lookup|Name or service not known", "its name is not known (DNS)"),
    (Denied, r"certificate|InvalidCertificate|UnknownIssuer", "its certificate is not trusted"),
    (Unreachable, r"TimedOut|Timeout|timed out|deadline", "no answer in time"),
    (Unreachable, r"SlowDown|ServiceUnavailable|\b50[0234] ", "it is not able to answer now"),
    (Denied, r"PermissionDenied|Permission denied|os error 13\b", "its folder is not ours to use"),
    (Denied, r"NotADirectory|Not a directory|os error 20\b|File exists", "it is a file, or lies in one"),
    (Denied, r"Read-only|os error 30\b", "it is read-only"),
    (Unreachable, r"IncompleteBody|IncompleteMessage|UnexpectedEof|ConnectionReset|ChannelClosed|error sending request"
                  r"|Body|Decode", "the connection broke off"),
)


def unreachable(text: str) -> Unreachable:
    """The error for obstore's message: a known reason, else the code of the error, if there is one."""
    for kind, pattern, reason in REASONS:
        if re.search(pattern, text):
            return kind(reason)
    code = re.search(r"<Code>([A-Za-z]{1,60})</Code>", text) or re.search(r"status code: (\d{3})", text)
    return Unreachable(f"it answers {code[1]}" if code else "an unknown error")
