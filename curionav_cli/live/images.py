"""Images of a robot's camera, from messages to the observation's 64 x 64 pixels."""

from __future__ import annotations

import cv2
import numpy as np

from curionav_cli.constants import IMAGE_SIDE
from curionav_cli.live.messages import expected, raw_bytes
from curionav_cli.live.safety import MessageFault
from curionav_cli.live.transport import Message
from curionav_cli.world.render.renderer import FAR

COLOURS = {  # encoding of sensor_msgs/Image: channels, and how OpenCV turns it into RGB
    "rgb8": (3, None), "bgr8": (3, cv2.COLOR_BGR2RGB), "rgba8": (4, cv2.COLOR_RGBA2RGB),
    "bgra8": (4, cv2.COLOR_BGRA2RGB), "mono8": (1, cv2.COLOR_GRAY2RGB),
}
DEPTHS = {"32FC1": (np.float32, 1.0), "16UC1": (np.uint16, 0.001)}  # and metres in a unit
LARGEST = 1 << 26  # pixels


def picture(message: Message, kind: str, crop: float) -> np.ndarray:
    """The image (64, 64, 3) uint8 RGB of a sensor_msgs/Image or CompressedImage of type `kind`; crop: see View."""
    with expected(kind):
        whole = compressed(message) if kind.endswith("CompressedImage") else colour(message)
    return cv2.resize(middle(whole, crop), (IMAGE_SIDE, IMAGE_SIDE), interpolation=cv2.INTER_AREA)


def compressed(message: Message) -> np.ndarray:
    """The RGB image of a CompressedImage: JPEG or PNG."""
    form = str(message["format"])
    broken = f"a compressed image (format {form!r}) that is neither JPEG nor PNG, or is broken"
    try:
        found = cv2.imdecode(np.frombuffer(raw_bytes(message["data"]), np.uint8), cv2.IMREAD_COLOR)
    except cv2.error as error:
        raise MessageFault(broken) from error
    if found is None:
        raise MessageFault(broken)
    return cv2.cvtColor(found, cv2.COLOR_BGR2RGB)


def colour(message: Message) -> np.ndarray:
    """The RGB image of an Image."""
    encoding = str(message["encoding"])
    if encoding not in COLOURS:
        raise MessageFault(f"an image with encoding {encoding!r}; it can be one of {', '.join(COLOURS)}")
    channels, conversion = COLOURS[encoding]
    found = pixels(message, np.dtype(np.uint8), channels)
    return found if conversion is None else cv2.cvtColor(found, conversion)


def depth(message: Message, kind: str, crop: float) -> np.ndarray:
    """The depth (64, 64) float32 of an Image, metres along the optical axis; where nothing is measured, FAR."""
    with expected(kind):
        encoding = str(message["encoding"])
        if encoding not in DEPTHS:
            raise MessageFault(f"depth with encoding {encoding!r}; it can be one of {', '.join(DEPTHS)}")
        dtype, unit = DEPTHS[encoding]
        kind_of = np.dtype(dtype).newbyteorder(">" if message.get("is_bigendian") else "<")
        whole = pixels(message, kind_of, 1).astype(np.float32) * np.float32(unit)
    found = cv2.resize(middle(whole, crop), (IMAGE_SIDE, IMAGE_SIDE), interpolation=cv2.INTER_NEAREST)
    return np.where(np.isfinite(found) & (found > 0.0), found, FAR).clip(0.0, FAR).astype(np.float32)


def pixels(message: Message, dtype: np.dtype, channels: int) -> np.ndarray:
    """The pixels (height, width) or (height, width, channels) of an Image, whose rows may be padded."""
    height, width, row = int(message["height"]), int(message["width"]), int(message["step"])
    needed, data = width * channels * dtype.itemsize, raw_bytes(message["data"])
    if not 0 < height * width <= LARGEST or row < needed or len(data) < height * row:
        raise MessageFault(f"an image of {width} x {height} pixels with {len(data)} bytes, rows of {row}")
    rows = np.frombuffer(data, np.uint8, height * row).reshape(height, row)[:, :needed]
    flat = np.ascontiguousarray(rows).view(dtype)
    return flat.reshape((height, width, channels) if channels > 1 else (height, width))


def middle(image: np.ndarray, crop: float) -> np.ndarray:
    """The square in the middle whose side is `crop` of the shorter side."""
    height, width = image.shape[:2]
    side = max(1, round(crop * min(height, width)))
    top, left = (height - side) // 2, (width - side) // 2
    return np.ascontiguousarray(image[top:top + side, left:left + side])
