#include "MotionSpliceRetargetAsset.h"

#include "BonePose.h"
#include "Roles/LiveLinkAnimationTypes.h"

void UMotionSpliceRetargetAsset::BuildPoseFromAnimationData(float, const FLiveLinkSkeletonStaticData* InSkeletonData,
	const FLiveLinkAnimationFrameData* InFrameData, FCompactPose& OutPose)
{
	TArray<FTransform> Bind; // of the mesh's bones, in the mesh's axes
	TArray<FTransform> Above; // of the bones' parents
	for (const FCompactPoseBoneIndex Bone : OutPose.ForEachBoneIndex())
	{
		const FCompactPoseBoneIndex Parent = OutPose.GetParentBoneIndex(Bone);
		Above.Add(Parent.GetInt() == INDEX_NONE ? FTransform::Identity : Bind[Parent.GetInt()]);
		Bind.Add(OutPose.GetRefPose(Bone) * Above.Last());
	}
	const FQuat Yaw(FVector::UpVector, FMath::DegreesToRadians(MeshYaw));
	const TArray<FName>& Names = InSkeletonData->GetBoneNames();
	for (int32 Joint = 0; Joint < FMath::Min(Names.Num(), InFrameData->Transforms.Num()); ++Joint)
	{
		const int32 MeshBone = OutPose.GetBoneContainer().GetPoseBoneIndexForBoneName(Names[Joint]);
		if (MeshBone == INDEX_NONE)
		{
			continue;
		}
		const FCompactPoseBoneIndex Bone =
			OutPose.GetBoneContainer().MakeCompactPoseIndex(FMeshPoseBoneIndex(MeshBone));
		if (Bone.GetInt() == INDEX_NONE)
		{
			continue;
		}
		const FTransform& Given = InFrameData->Transforms[Joint];
		const FTransform& Parent = Above[Bone.GetInt()];
		const FQuat Rotation = Yaw * Given.GetRotation() * Yaw.Inverse();
		OutPose[Bone].SetRotation(Parent.GetRotation().Inverse() * Rotation * Bind[Bone.GetInt()].GetRotation());
		if (Joint == 0)
		{
			OutPose[Bone].SetTranslation(Parent.InverseTransformPosition(Yaw.RotateVector(Given.GetTranslation())));
		}
	}
}
