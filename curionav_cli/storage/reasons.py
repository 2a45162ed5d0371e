"""Why a storage gave no answer, in our own words: the errors of obstore quote requests and what a server said."""

from __future__ import annotations

import re

REASONS = (  # the first that is found
    (r"RequestTimeTooSkewed|RequestExpired|difference between the request time",
     "it says that this machine's clock is wrong: set it"),
    (r"Error parsing Path|InvalidPath|parse path", "it holds an object with a name that leads elsewhere: remove that"),
    (r"NoSuchBucket", "it has no such bucket"),
    (r"No space left|os error 28\b|StorageFull|Quota|QuotaExceeded|InsufficientStorage|\b507\b", "it is full"),
    (r"InvalidAccessKeyId|SignatureDoesNotMatch|AccessDenied|InvalidToken|ExpiredToken|Unauthenticated|\b40[13] ",
     "it refuses our key"),
    (r"169\.254\.169\.254|169\.254\.170\.2|CredentialProvider|InstanceCredential", "there is no key for it"),
    (r"ConnectionRefused|Connection refused", "the connection was refused"),
    (r"dns error|failed to lookup|Name or service not known", "its name is not known (DNS)"),
    (r"certificate|InvalidCertificate|UnknownIssuer", "its certificate is not trusted"),
    (r"TimedOut|Timeout|timed out|deadline", "no answer in time"),
    (r"SlowDown|ServiceUnavailable|\b50[0234] ", "it is not able to answer now"),
    (r"PermissionDenied|Permission denied|os error 13\b", "its folder is not ours to use"),
    (r"Read-only|os error 30\b", "it is read-only"),
    (r"IncompleteBody|IncompleteMessage|UnexpectedEof|ConnectionReset|ChannelClosed|error sending request|Body|Decode",
     "the connection broke off"),
)


def reason(text: str) -> str:
    """One of the reasons that are known; else the code of the error, if there is one."""
    for pattern, words in REASONS:
        if re.search(pattern, text):
            return words
    code = re.search(r"<Code>([A-Za-z]{1,60})</Code>", text) or re.search(r"status code: (\d{3})", text)
    return f"it answers {code[1]}" if code else "an error that is not known"
