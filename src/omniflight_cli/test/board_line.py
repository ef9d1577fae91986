"""What the emulated boards received from the gateway, from the emulator's line_log."""

import math

FRAME_BEGIN, FRAME_END, ESCAPE, FORGET = 0x5E, 0x24, 0x5C, 0x21
STOP_HALF_PERIOD = 32767  # us; also the number for "slower than 15.259 Hz"


class Line:
    """commands: [(t [s, CLOCK_MONOTONIC], board, speeds [rad/s])], a stop of all motors has speeds None."""

    def __init__(self, path):
        self.commands = []
        frames = {}
        with open(path) as log:
            for row in log:
                t_ns, board, data = row.split()
                frame = frames.setdefault(board, [None, False])
                for byte in bytes.fromhex(data):
                    self.push(frame, byte, int(t_ns) * 1e-9, int(board))

    def push(self, frame, byte, t, board):
        if byte == FRAME_BEGIN:
            frame[:] = [bytearray(), False]
        elif byte == FRAME_END and frame[0] is not None:
            self.take(bytes(frame[0]), t, board)
            frame[0] = None
        elif byte == FORGET:
            frame[0] = None
        elif frame[0] is not None:
            if byte == ESCAPE:
                frame[1] = True
            else:
                frame[0].append(byte ^ 0xFF if frame[1] else byte)
                frame[1] = False

    def take(self, body, t, board):
        if body[:1] == b"x":
            self.commands.append((t, board, None))
        elif body[:1] == b"w":
            counts = [int.from_bytes(body[k:k + 2], "big", signed=True) for k in range(1, len(body), 2)]
            self.commands.append((t, board, [0.0 if abs(n) >= STOP_HALF_PERIOD or n == 0 else math.pi * 1e6 / n
                                             for n in counts]))

    def board(self, board):
        """[(t, largest |speed|, speeds)] of one board; a stop is (t, 0, None)."""
        return [(t, max(map(abs, speeds)) if speeds else 0.0, speeds) for t, b, speeds in self.commands if b == board]
