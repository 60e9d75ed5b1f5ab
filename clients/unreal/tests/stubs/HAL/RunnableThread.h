#pragma once
#include <thread>

#include "HAL/Runnable.h"

class FRunnableThread
{
public:
	static FRunnableThread* Create(FRunnable* Runnable, const TCHAR*) { return new FRunnableThread(Runnable); }
	~FRunnableThread() { Kill(true); }
	bool Kill(bool bShouldWait)
	{
		Runnable->Stop();
		if (bShouldWait && Thread.joinable())
		{
			Thread.join();
		}
		return true;
	}

private:
	explicit FRunnableThread(FRunnable* InRunnable) : Runnable(InRunnable), Thread([InRunnable] { InRunnable->Run(); }) {}

	FRunnable* Runnable;
	std::thread Thread;
};
