"""Track a clip, see how it went and read joints off: `python examples/1_track_a_session.py`."""

from pathlib import Path

from keypose.tracker import (
    SegmentFinished,
    TrackFinished,
    load_session,
    open_video_of,
    track_session,
    verdict_words,
)

BOX = Path(__file__).parents[1] / "sample_videos" / "box" / "session.json"


def main() -> None:
    session = load_session(BOX)
    with open_video_of(session, BOX) as video:
        for event in track_session(session, video):
            if isinstance(event, SegmentFinished):
                print(f"segment {event.index}: {verdict_words(event.result.verdict)}")
            if isinstance(event, TrackFinished):
                result = event.result

    motion = result.trajectory
    p_camera_joint = motion.joints(result.skeleton)  # (frames, joints, 3), metres
    uv = session.view.camera.project(p_camera_joint)  # (frames, joints, 2), pixels
    for frame in range(motion.first_frame, motion.last_frame + 1, 10):
        x, y, z = p_camera_joint[frame - motion.first_frame, 0]
        u, v = uv[frame - motion.first_frame, 0]
        print(f"frame {frame:2}: {x:+.2f} {y:+.2f} {z:.2f} m, seen at pixel {u:.0f} {v:.0f}")


if __name__ == "__main__":
    main()
