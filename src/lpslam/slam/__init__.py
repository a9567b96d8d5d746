"""RGB-D visual SLAM on ORB-SLAM2's design; knows nothing of text or language."""
