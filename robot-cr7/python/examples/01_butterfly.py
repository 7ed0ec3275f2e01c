"""Plan the butterfly on the CR7 and draw it: butterfly.png."""

import arcfeed

motion = arcfeed.plan(arcfeed.Path.butterfly(), "cr7", arcfeed.Job(feed={"feed_mm_s": 100}))
print(motion.summary)
motion.plot("butterfly.png")
